//! Decoding of a text file's bytes.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Decodes a text file, and normalises its line endings to `\
/// `.
///
/// A byte order mark names the encoding. Without one, a zero in every second byte means UTF-16; otherwise the text is UTF-8, or
/// Windows-1252 if it is not valid UTF-8 (a degree sign or a micro sign of an old export).
///
/// # Errors
/// A description of bytes that are not text.
pub(super) fn text(bytes: &[u8]) -> Result<String, String> {
    let encoding = Encoding::for_bom(bytes).map_or_else(|| guess(bytes), |(encoding, _)| encoding);
    let (text, _, broken) = encoding.decode(bytes);
    if broken || text.contains('\0') {
        return Err(format!("bytes that are not {} text", encoding.name()));
    }
    Ok(text.replace("\r\n", "\n").replace('\r', "\n"))
}

fn guess(bytes: &[u8]) -> &'static Encoding {
    let begin = &bytes[..bytes.len().min(200) / 2 * 2];
    let zeros = |odd: usize| begin.iter().skip(odd).step_by(2).filter(|byte| **byte == 0).count();
    let most = begin.len() * 2 / 5;
    match (zeros(0), zeros(1)) {
        (0, odd) if odd > most => UTF_16LE,
        (even, 0) if even > most => UTF_16BE,
        _ if std::str::from_utf8(bytes).is_ok() => UTF_8,
        _ => WINDOWS_1252,
    }
}
