//! `doctor --bundle`: a text with the data that a bug report needs, without keys.

use super::report::Report;
use firmware_image::process;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::terminal::json;
use std::path::Path;
use std::process::Command;

/// A text longer than this is cut, because people read the report.
const LONGEST: usize = 100_000;

/// The text in Markdown: versions, the checks, the scene and its robot. Paths below the home folder begin with `~`.
pub(super) fn text(report: &Report<'_>, scene: Option<&SceneFile>) -> Result<String, Failure> {
    let output = |program: &str, arguments: &[&str]| {
        process::output(Command::new(program).args(arguments).current_dir(process::root()))
    };
    let said = |program: &str, arguments: &[&str]| output(program, arguments).unwrap_or_else(|| "unknown".to_owned());
    let changed = output("git", &["status", "--porcelain"]);
    let mut text = format!(
        "# Bug report\n\nWhat I did:\n\nWhat I expected:\n\nWhat happened instead:\n\n## Versions\n\n\
         | | |\n|---|---|\n| newtau | {} |\n| commit | {} |\n| changed files | {} |\n| link protocol | {} |\n| system | {} {} |\n| rustc | {} |\n| QEMU | {} |\n",
        env!("CARGO_PKG_VERSION"),
        said("git", &["rev-parse", "--short", "HEAD"]),
        changed.map_or_else(|| "unknown".to_owned(), |files| files.lines().count().to_string()),
        link::PROTOCOL_VERSION,
        std::env::consts::OS,
        std::env::consts::ARCH,
        said("rustc", &["--version"]),
        said("qemu-system-arm", &["--version"]).lines().next().unwrap_or_default(),
    );
    text += &format!("\n## Checks\n\n```json\n{}\n```\n", json(report)?);
    if let Some(scene) = scene {
        let robot = &scene.robot.path;
        for path in [&scene.path, robot] {
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            let content = std::fs::read_to_string(path).unwrap_or_else(|error| error.to_string());
            text += &format!("\n## {}\n\n```{ending}\n{}\n```\n", path.display(), cut(content.trim_end()));
        }
    }
    text +=
        "\nAttach the record of the session (`newtau connect --record`) or `log.csv` of the run, if there is one.\n";
    Ok(private(&text, std::env::var("HOME").ok().as_deref()))
}

/// The first part of a long text.
fn cut(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}\n.. cut: {} bytes in all", &text[..end], text.len()),
    }
}

/// Removes the name of the home folder from a text, and anything that looks like a key: 64 hexadecimal digits in a row.
fn private(text: &str, home: Option<&str>) -> String {
    let text = home
        .filter(|home| Path::new(home).components().count() > 1)
        .map_or_else(|| text.to_owned(), |home| text.replace(home, "~"));
    let (mut out, mut digits) = (String::with_capacity(text.len()), String::new());
    for letter in text.chars().chain(['\0']) {
        if letter.is_ascii_hexdigit() {
            digits.push(letter);
            continue;
        }
        out += if digits.len() >= 64 { "[a key was here]" } else { &digits };
        digits.clear();
        if letter != '\0' {
            out.push(letter);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::private;

    #[test]
    fn no_key_and_no_home_folder_is_in_a_report() {
        let key = "00112233445566778899aabbccddeeff00112233445566778899AABBCCDDEEFF";
        let text = private(&format!("/home/ada/arm.key\n{key}\n0123 {key}ab."), Some("/home/ada"));
        assert_eq!(text, "~/arm.key\n[a key was here]\n0123 [a key was here].");
        // The root folder as the home folder is not replaced, and 63 digits are not a key.
        assert_eq!(private(&format!("/x {}", &key[1..]), Some("/")), format!("/x {}", &key[1..]));
    }
}
