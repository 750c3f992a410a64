//! Detection of files from other programs that are not text.

/// First bytes of a file, its kind, and what to export instead.
const KNOWN: &[(&[u8], &str, &str)] = &[
    (b"PK\x03\x04", "a ZIP archive or a spreadsheet (.xlsx, .ods, .npz)", "the sheet exported as CSV"),
    (b"\xd0\xcf\x11\xe0", "a spreadsheet (.xls)", "the sheet exported as CSV"),
    (b"#ROSBAG V", "a ROS 1 bag", "its joint states as CSV, for example exported by PlotJuggler"),
    (
        b"SQLite format 3\0",
        "an SQLite database (ROS 2 bag, .db3)",
        "its joint states as CSV, for example exported by PlotJuggler",
    ),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file", "its arrays as CSV (writetable)"),
    (b"\x89HDF\r\n", "an HDF5 or MATLAB file", "its arrays as CSV"),
    (b"PAR1", "a Parquet file", "its table as CSV"),
    (b"\x93NUMPY", "a NumPy array", "the array as CSV with a header (numpy.savetxt)"),
    (b"\x1f\x8b", "a compressed file (gzip)", "the unpacked file"),
    (b"(\xb5/\xfd", "a compressed file (zstd)", "the unpacked file"),
    (b"%PDF", "a PDF", "a log as CSV"),
    (b"<", "an HTML or XML page", "a log as CSV"),
    (b"{", "JSON", "a log as CSV, one row for each sample"),
];

/// Found and expected content, if a file is not a text of rows.
pub(super) fn problem(bytes: &[u8]) -> Option<(String, String)> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Some(("an empty file".to_owned(), "a log: a header and rows of numbers".to_owned()));
    }
    if bytes.starts_with(b"version https://git-lfs") {
        return Some(("a pointer of Git LFS".to_owned(), "the file itself: git lfs pull".to_owned()));
    }
    let known = KNOWN.iter().find(|(begin, ..)| bytes.starts_with(begin));
    known.map(|(_, found, expected)| ((*found).to_owned(), (*expected).to_owned()))
}
