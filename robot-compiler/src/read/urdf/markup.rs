//! The XML of a URDF file: its numbers, and the locations for errors.

use crate::describe::diagnostics::{FileError, Source, one_of};
use crate::describe::draft::Place;
use roxmltree::{Document, Node};
use std::ops::Range;

/// Deepest nesting: a URDF needs six levels.
const DEPTH_MAX: usize = 32;

/// Advice for a xacro file.
pub(in crate::read) const EXPAND: &str = "the URDF that `xacro FILE > robot.urdf` writes";

pub(super) fn parse(source: &Source) -> Result<Document<'_>, FileError> {
    Document::parse(&source.text).map_err(|error| {
        let at = error.pos();
        let offset = offset(&source.text, at.row, at.col);
        // The parser's message ends with the location, with which our message begins.
        let text = error.to_string();
        let message = text.strip_suffix(&format!(" at {at}")).unwrap_or(&text);
        source.error(offset..offset + 1, "", format!("not valid XML: {message}"), "an XML document")
    })
}

/// Byte offset of a row and a column, both counted from 1, the column in characters.
fn offset(text: &str, row: u32, column: u32) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum();
    let line = text.get(line_start..).unwrap_or_default();
    line_start + line.chars().take(column.saturating_sub(1) as usize).map(char::len_utf8).sum::<usize>()
}

/// A document and its source text.
pub(super) struct Markup<'a> {
    source: &'a Source,
    pub(super) robot: Node<'a, 'a>,
    /// Major and minor version; 1.0 if the file gives none or an invalid one.
    pub(super) version: (u32, u32),
}

impl<'a> Markup<'a> {
    pub(super) fn new(source: &'a Source, document: &'a Document<'a>) -> Result<Self, FileError> {
        let robot = document.root_element();
        let version = robot.attribute("version").and_then(|version| {
            let (major, minor) = version.trim().split_once('.')?;
            Some((major.parse().ok()?, minor.parse().ok()?))
        });
        let markup = Self { source, robot, version: version.unwrap_or((1, 0)) };
        if !robot.has_tag_name("robot") {
            let name = robot.tag_name().name();
            let problem = format!("the outermost element is <{name}>");
            let expected = match name {
                "sdf" => "<robot>: this is an SDF model; its URDF is mostly in the same package",
                "mujoco" => "<robot>: this is a MuJoCo model; its URDF is mostly in the maker's package",
                _ => "<robot>",
            };
            return Err(markup.error(&robot, "robot", problem, expected));
        }
        let is_macro = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|name| name.contains("xacro"));
        if let Some(found) = robot.descendants().find(is_macro) {
            let problem = format!("a xacro file: <xacro:{}> is not expanded", found.tag_name().name());
            return Err(markup.error(&found, "robot", problem, EXPAND));
        }
        if let Some(deep) = robot.descendants().find(|node| node.ancestors().take(DEPTH_MAX + 2).count() > DEPTH_MAX) {
            return Err(markup.error(&deep, "robot", "elements nested too deeply", "at most 30 levels"));
        }
        Ok(markup)
    }

    /// The `name` of a link or joint.
    pub(super) fn name(&self, node: &Node<'a, 'a>, kind: &str) -> Result<&'a str, FileError> {
        let name = node.attribute("name").unwrap_or_default();
        if name.is_empty() {
            return Err(self.error(node, format!("{kind}.name"), "missing", format!("a name for the {kind}")));
        }
        self.printable(node, name, kind)
    }

    /// A name without control characters, which could control a terminal.
    pub(super) fn printable(&self, node: &Node<'a, 'a>, name: &'a str, kind: &str) -> Result<&'a str, FileError> {
        if name.chars().any(char::is_control) {
            let problem = format!("found {name:?}");
            return Err(self.error(node, format!("{kind}.name"), problem, "a name in characters that can be printed"));
        }
        Ok(name)
    }

    /// A child element that may occur at most once.
    pub(super) fn only_child(
        &self,
        node: &Node<'a, 'a>,
        name: &str,
        label: &str,
    ) -> Result<Option<Node<'a, 'a>>, FileError> {
        let mut all = node.children().filter(|child| child.has_tag_name(name));
        match (all.next(), all.next()) {
            (_, Some(second)) => {
                Err(self.error(&second, format!("{label}.{name}"), "given twice", format!("one <{name}>")))
            }
            (first, None) => Ok(first),
        }
    }

    /// The finite numbers in an attribute, if it exists.
    pub(super) fn finite<const N: usize>(
        &self,
        element: &Node<'a, 'a>,
        attribute: &str,
        label: &str,
    ) -> Result<Option<[f64; N]>, FileError> {
        self.numbers(element, attribute, label, |x| (x as f32).is_finite())
    }

    /// The finite numbers in a required attribute.
    pub(super) fn required<const N: usize>(
        &self,
        element: &Node<'a, 'a>,
        attribute: &str,
        label: &str,
    ) -> Result<[f64; N], FileError> {
        self.finite(element, attribute, label)?
            .ok_or_else(|| self.error(element, field(element, attribute, label), "missing", finite_numbers(N)))
    }

    /// The number in an attribute, if it exists; it may be infinite.
    pub(super) fn bound(&self, element: &Node<'a, 'a>, attribute: &str, label: &str) -> Result<Option<f64>, FileError> {
        let number = self.numbers(element, attribute, label, |x| !x.is_nan())?;
        Ok(number.map(|[x]| x))
    }

    fn numbers<const N: usize>(
        &self,
        element: &Node<'a, 'a>,
        attribute: &str,
        label: &str,
        good: fn(f64) -> bool,
    ) -> Result<Option<[f64; N]>, FileError> {
        let Some(found) = element.attribute_node(attribute).filter(|found| !found.value().trim().is_empty()) else {
            return Ok(None);
        };
        let words = found.value().split_whitespace();
        let numbers = words.map(|word| word.parse().ok().filter(|x| good(*x))).collect::<Option<Vec<f64>>>();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.map(Some).ok_or_else(|| {
            let problem = format!("found {:?}", found.value().chars().take(60).collect::<String>());
            self.error_at(found.range(), field(element, attribute, label), problem, finite_numbers(N))
        })
    }

    /// An error at a location in the text.
    pub(super) fn error_at(
        &self,
        place: Range<usize>,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        self.source.error(place, field, problem, expected)
    }

    /// An error at the opening tag of an element.
    pub(super) fn error(
        &self,
        node: &Node<'a, 'a>,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        self.source.error(self.tag(node), field, problem, expected)
    }

    /// The opening tag of an element.
    pub(super) fn tag(&self, node: &Node<'_, '_>) -> Range<usize> {
        let range = node.range();
        let text = self.source.text.get(range.clone()).unwrap_or_default();
        let tag = text.find('>').map_or(range.len(), |end| end + 1);
        range.start..range.start + tag
    }

    /// The location of a child element, or of the element itself if the child is missing.
    pub(super) fn place(&self, node: &Node<'_, '_>, element: &str, field: String) -> Place {
        let found = child(node, element);
        let given = found.is_some();
        Place { span: self.tag(&found.unwrap_or(*node)), field, given }
    }

    /// An error at a child element, or at the element itself if the child is missing.
    pub(super) fn error_in(
        &self,
        node: &Node<'a, 'a>,
        element: &str,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        self.error(&child(node, element).unwrap_or(*node), field, problem, expected)
    }

    /// An error about a missing link.
    pub(super) fn unknown_link(
        &self,
        node: &Node<'a, 'a>,
        field: impl Into<String>,
        name: &str,
        known: &[&str],
    ) -> FileError {
        self.error(node, field, format!("there is no link {name:?}"), one_of(name, known))
    }
}

/// The first child element of this name.
pub(super) fn child<'a>(node: &Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// Name of an attribute in errors.
fn field(element: &Node<'_, '_>, attribute: &str, label: &str) -> String {
    format!("{label}.{}.{attribute}", element.tag_name().name())
}

fn finite_numbers(count: usize) -> String {
    if count == 1 { "one finite number".to_owned() } else { format!("{count} finite numbers") }
}
