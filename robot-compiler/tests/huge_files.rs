//! Files of absurd size, depth and content are rejected quickly, with a message that fits on a screen.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test names the file that fails")]

use miette::{GraphicalReportHandler, GraphicalTheme};
use robot_compiler::{Ends, FileError, Robot, SceneFile};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Longest message, bytes, and longest line of the file in it, columns.
const MESSAGE: usize = 8000;
const COLUMNS: usize = 230;

fn render(error: &FileError) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(1_000_000);
    handler.render_report(&mut text, error).unwrap();
    text
}

/// The message of a rejected text, which must be short and come quickly.
fn refused(what: &str, error: impl FnOnce() -> FileError) -> String {
    let start = Instant::now();
    let error = error();
    let message = render(&error);
    let took = start.elapsed().as_secs_f64();
    println!("{what}: {took:.2} s, {} bytes", message.len());
    assert!(took < 30.0, "{what}: {took:.1} s");
    assert!(message.len() < MESSAGE, "{what}: {} bytes", message.len());
    let widest = message.lines().filter(|line| line.contains('\u{2502}')).map(|line| line.chars().count()).max();
    assert!(widest.unwrap_or(0) < COLUMNS, "{what}: {widest:?} columns");
    message
}

fn toml(text: &str) -> FileError {
    Robot::from_toml_str(text, "huge.toml").unwrap_err()
}

fn urdf(text: &str) -> FileError {
    Robot::from_urdf_str(text, "huge.urdf", Ends::default()).unwrap_err()
}

fn file(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("{}-{name}", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_place_in_a_huge_file_is_shown_on_a_screen() {
    let many = "1, ".repeat(1_000_000);
    let joint = |mass: &str| format!("name = \"a\"\n[[joint]]\nname = \"j\"\ntype = \"revolute\"\nmass = {mass}\n");
    let frame = "dh = { a = 0, alpha = 0, d = 0, theta = 0 }\n";
    let message = refused("a list", || toml(&(joint(&format!("[{many}]")) + frame)));
    assert!(message.contains("found an array of 1000000 entries") && message.contains("mass = [1, 1, 1"), "{message}");
    let lines = many.replace(' ', "\n");
    let message = refused("a list over many lines", || toml(&(joint(&format!("[{lines}]")) + frame)));
    assert!(message.contains("[huge.toml:5:8]"), "{message}");
    let long = "x".repeat(3_000_000);
    refused("a word", || toml(&joint(&format!("\"{long}\""))));
    refused("a key", || toml(&format!("name = \"a\"\n{long} = 1\n")));
    refused("a remark behind", || toml(&format!("name = \"a\" # {long}\n{frame}")));
    refused("no end", || toml(&format!("name = \"{long}")));
    refused("a remark before", || toml(&format!("{}= 3 # {long}", " ".repeat(1000))));
    refused("lists in lists", || toml(&format!("name = {}", "[".repeat(200_000))));
    refused("tables in tables", || toml(&format!("name = {}", "{a=".repeat(200_000))));
    refused("dots", || toml(&format!("a{} = 1", ".a".repeat(200_000))));
    refused("elements in elements", || urdf(&format!("<robot>{}", "<a>".repeat(200_000))));
    refused("nested elements", || urdf(&format!("<robot>{}{}</robot>", "<a>".repeat(900), "</a>".repeat(900))));
    refused("an attribute", || urdf(&format!("<robot name=\"r\"><link/><link name=\"{long}\"/></robot>")));
    refused("a name", || urdf(&format!("<robot><link name=\"{long}\"/><link name=\"{long}\"/></robot>")));
    let links = |count: usize| -> String { (0..count).map(|i| format!("<link name=\"link{i}\"/>")).collect() };
    let message = refused("too many links", || urdf(&format!("<robot>{}</robot>", links(10_001))));
    assert!(message.contains("found 10001 links"), "{message}");
    let many = links(10_000);
    let joint = "<joint name=\"j\" type=\"fixed\"><parent link=\"lin\"/><child link=\"link2\"/></joint>";
    let message = refused("links", || urdf(&format!("<robot>{many}{joint}</robot>")));
    assert!(message.contains("link39, and 9960 more; did you mean"), "{message}");
}

#[test]
fn a_deep_tree_of_links_is_read_soon() {
    for kind in ["fixed", "revolute"] {
        let links: String = (0..10_000).map(|i| format!("<link name=\"l{i}\"/>")).collect();
        let joints: String = (1..10_000)
            .map(|i| {
                let (parent, child) = (i - 1, i);
                format!("<joint name=\"j{i}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{child}\"/></joint>")
            })
            .collect();
        refused(kind, || urdf(&format!("<robot>{links}{joints}</robot>")));
    }
}

/// The location is that in the whole file; the line is shortened around it.
#[test]
fn a_long_line_is_cut_around_the_error() {
    let text = format!("name = \"a\"\nsource = \"{}\"; oh = \"{}\"\n", "s".repeat(500), "t".repeat(500));
    let error = toml(&text);
    let (line, column) = error.line_column().unwrap();
    let message = render(&error);
    assert_eq!(line, 2);
    assert!((500..530).contains(&column), "{column}");
    assert!(message.contains(&format!("[huge.toml:2:{column}]")), "{message}");
    let shown = message.lines().find(|line| line.trim_start().starts_with("2 \u{2502}")).unwrap();
    assert!(shown.contains("sss\"; oh = \"ttt") && shown.chars().count() <= COLUMNS, "{message}");
    // Characters of more than one byte are never cut.
    for shift in 0..4 {
        let text = format!("name = \"a\"\nsource = \"{}{}\"; oh = 1\n", "x".repeat(shift), "\u{1d11e}é".repeat(300));
        assert!(render(&toml(&text)).contains("\u{1d11e}é\"; oh = 1"));
    }
}

#[test]
fn a_file_beyond_the_stated_size_is_refused() {
    let path = file("large.toml", &"#".repeat((4 << 20) + 1));
    let error = Robot::load(&path).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((error.problem(), error.expected()), ("larger than 4 MiB", "a file of at most 4 MiB"));
    #[cfg(unix)]
    {
        // A file without an end.
        let path = std::env::temp_dir().join(format!("{}-endless.toml", std::process::id()));
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        let error = Robot::load(&path).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(error.problem(), "larger than 4 MiB");
    }
}

#[test]
fn no_character_of_a_file_reaches_the_terminal_as_a_command() {
    let planar = std::fs::read_to_string(crate::common::top("robots/planar2r.toml")).unwrap();
    let swing = std::fs::read_to_string(crate::common::top("scenes/planar2r_swing.toml")).unwrap();
    let two = include_str!("data/two.urdf");
    let place = crate::common::top("scenes/any.toml");
    let scene = |text: &str| SceneFile::from_toml_str(text, &place).unwrap_err();
    let renamed = |text: &str, name: &str| {
        let (before, behind) = text.split_once("name = \"").unwrap();
        format!("{before}name = \"{name}{behind}")
    };
    let errors = [
        // Escaped, as TOML allows it, and unescaped, which TOML rejects.
        toml(&renamed(&planar, "\\u001b[31m")),
        toml(&renamed(&planar, "\u{1b}[31m")),
        toml(&renamed(&planar, "\u{9b}31m")),
        toml(&planar.replacen("name = \"shoulder", "name = \"\\u001b[31m", 1)),
        toml(&planar.replacen("source = \"", "source = \"\\u001b[31m", 1)),
        toml(&planar.replacen("[[joint]]", "\"\\u001b[31m\" = 1\n[[joint]]", 1)),
        scene(&renamed(&swing, "\\u001b[31m")),
        scene(&swing.replacen("robot = \"", "robot = \"\\u001b[31m", 1)),
        urdf(&two.replacen("name=\"two\"", "name=\"\u{9b}31m\"", 1)),
        urdf(&two.replace("\"fore\"", "\"\u{9b}31m\"")),
        urdf(&two.replace("\"elbow\"", "\"&#10;\"")),
        Robot::load(Path::new("\u{1b}[31m.toml")).unwrap_err(),
    ];
    for error in errors {
        let message = render(&error);
        let wrong = message.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(wrong, None, "{message:?}");
        assert!(!error.to_string().contains(char::is_control), "{error}");
    }
    assert!(toml(&renamed(&planar, "\\u001b[31m")).problem().contains("found the control character"));
    // A source may have several lines.
    assert!(Robot::from_toml_str(&planar.replacen("source = \"", "source = \"a\\nb\\t", 1), "a.toml").is_ok());
}

#[test]
fn folders_and_xacro_files_are_called_what_they_are() {
    let folder = crate::common::top("robots");
    assert_eq!(Robot::load(&folder).unwrap_err().problem(), "it is a folder");
    assert_eq!(SceneFile::load(&folder).unwrap_err().problem(), "cannot be read: it is a folder");
    let scene = "name = \"a\"\nrobot = \"../robots\"\n[motion]\nkind = \"hold\"\n";
    let error = SceneFile::from_toml_str(scene, &crate::common::top("scenes/any.toml")).unwrap_err();
    assert!(error.problem().starts_with("found the folder "), "{error}");

    const XACRO: &str =
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name=\"r\">\n<xacro:include filename=\"a\"/>\n</robot>";
    let error = urdf(XACRO);
    assert_eq!((error.line_column(), error.problem()), (Some((2, 1)), "a xacro file: <xacro:include> is not expanded"));
    assert!(error.expected().contains("`xacro FILE > robot.urdf`"), "{}", error.expected());
    let error = Robot::load(Path::new("arm.urdf.xacro")).unwrap_err();
    assert!(error.problem().starts_with("a xacro file") && error.expected().contains("`xacro FILE"), "{error}");
    // The output of xacro still names its namespace.
    let two =
        include_str!("data/two.urdf").replacen("<robot ", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ", 1);
    assert!(Robot::from_urdf_str(&two, "two.urdf", Ends::default()).is_ok());
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_file() {
    let mark = "\u{feff}";
    let planar = std::fs::read_to_string(crate::common::top("robots/planar2r.toml")).unwrap();
    assert!(Robot::from_toml_str(&format!("{mark}{planar}"), "a.toml").is_ok());
    let two = include_str!("data/two.urdf");
    assert!(Robot::from_urdf_str(&format!("{mark}{two}"), "two.urdf", Ends::default()).is_ok());
}
