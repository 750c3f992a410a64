//! The XML of a URDF file, for places and for what must be there.

use crate::describe::diagnostics::{FileError, Source, one_of};
use roxmltree::{Document, Node};

/// Deepest nesting: a URDF needs six levels, and the readers behind are recursive.
const DEPTH_MAX: usize = 32;

pub(super) fn parse(source: &Source) -> Result<Document<'_>, FileError> {
    Document::parse(&source.text).map_err(|error| {
        let at = error.pos();
        let offset = offset(&source.text, at.row, at.col);
        // The parser's message ends in the place, which stands in front of ours.
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

/// The parts of the document that matter, in its order.
pub(super) struct Markup<'a> {
    source: &'a Source,
    pub(super) robot: Node<'a, 'a>,
    pub(super) links: Vec<Node<'a, 'a>>,
    pub(super) joints: Vec<Node<'a, 'a>>,
}

/// The numbers in an attribute: how many, and whether infinity is one.
struct Numbers {
    element: &'static str,
    attribute: &'static str,
    count: usize,
    infinite: bool,
    required: bool,
}

const fn numbers(
    element: &'static str,
    attribute: &'static str,
    count: usize,
    infinite: bool,
    required: bool,
) -> Numbers {
    Numbers { element, attribute, count, infinite, required }
}

const NUMBERS: [Numbers; 18] = [
    numbers("origin", "xyz", 3, false, false),
    numbers("origin", "rpy", 3, false, false),
    numbers("axis", "xyz", 3, false, true),
    numbers("limit", "lower", 1, true, false),
    numbers("limit", "upper", 1, true, false),
    numbers("limit", "effort", 1, true, false),
    numbers("limit", "velocity", 1, true, false),
    numbers("dynamics", "damping", 1, false, false),
    numbers("dynamics", "friction", 1, false, false),
    numbers("mass", "value", 1, false, true),
    numbers("inertia", "ixx", 1, false, true),
    numbers("inertia", "iyy", 1, false, true),
    numbers("inertia", "izz", 1, false, true),
    numbers("inertia", "ixy", 1, false, true),
    numbers("inertia", "ixz", 1, false, true),
    numbers("inertia", "iyz", 1, false, true),
    numbers("mimic", "multiplier", 1, false, false),
    numbers("mimic", "offset", 1, false, false),
];

impl<'a> Markup<'a> {
    pub(super) fn new(source: &'a Source, document: &'a Document<'a>) -> Result<Self, FileError> {
        let robot = document.root_element();
        let named = |name: &'static str| robot.children().filter(move |node| node.has_tag_name(name)).collect();
        let markup = Self { source, robot, links: named("link"), joints: named("joint") };
        if !robot.has_tag_name("robot") {
            let problem = format!("the outermost element is <{}>", robot.tag_name().name());
            return Err(markup.error(&robot, "robot", problem, "<robot>"));
        }
        if let Some(deep) = robot.descendants().find(|node| node.ancestors().take(DEPTH_MAX + 2).count() > DEPTH_MAX) {
            return Err(markup.error(&deep, "robot", "elements nested too deeply", "at most 30 levels"));
        }
        Ok(markup)
    }

    /// Every attribute that dynamics or kinematics is read from holds as many numbers as it should.
    ///
    /// `urdf-rs` skips words that are no numbers in a vector, and knows no place.
    pub(super) fn check_numbers(&self) -> Result<(), FileError> {
        for (kind, nodes) in [("link", &self.links), ("joint", &self.joints)] {
            for node in nodes {
                let name = self.name(node, kind)?;
                if kind == "joint" {
                    self.check_joint(node, &format!("joint {name}"))?;
                }
                let inertial = child(node, "inertial");
                self.check_inertial(inertial.as_ref(), &format!("link {name}"))?;
                // A link's own children, and those of its inertial; shapes are nobody's business here.
                for element in node.children().chain(inertial.iter().flat_map(|inertial| inertial.children())) {
                    self.check_element(&element, &format!("{kind} {name}"))?;
                }
            }
        }
        Ok(())
    }

    /// A joint has a type that URDF knows, and two ends.
    fn check_joint(&self, node: &Node<'a, 'a>, label: &str) -> Result<(), FileError> {
        const TYPES: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];
        let kind = node.attribute_node("type");
        let Some(kind) = kind else {
            return Err(self.error(node, format!("{label}.type"), "missing", one_of("", &TYPES)));
        };
        if !TYPES.contains(&kind.value()) {
            let problem = format!("found {:?}", kind.value());
            return Err(self.source.error(
                kind.range(),
                format!("{label}.type"),
                problem,
                one_of(kind.value(), &TYPES),
            ));
        }
        for end in ["parent", "child"] {
            if child(node, end).is_none_or(|end| end.attribute("link").is_none()) {
                let expected = format!("<{end} link=\"...\"/>");
                return Err(self.error_in(node, end, format!("{label}.{end}"), "missing", expected));
            }
        }
        Ok(())
    }

    fn check_inertial(&self, inertial: Option<&Node<'a, 'a>>, label: &str) -> Result<(), FileError> {
        let Some(inertial) = inertial else {
            return Ok(());
        };
        for part in ["mass", "inertia"] {
            if child(inertial, part).is_none() {
                return Err(self.error(inertial, format!("{label}.inertial.{part}"), "missing", format!("<{part}>")));
            }
        }
        Ok(())
    }

    fn check_element(&self, element: &Node<'a, 'a>, label: &str) -> Result<(), FileError> {
        let tag = element.tag_name().name();
        for Numbers { attribute, count, infinite, required, .. } in NUMBERS.iter().filter(|rule| rule.element == tag) {
            let field = || format!("{label}.{tag}.{attribute}");
            let expected = if *count == 1 { "one finite number".to_owned() } else { format!("{count} finite numbers") };
            let Some(found) = element.attribute_node(*attribute) else {
                if *required {
                    return Err(self.error(element, field(), "missing", expected));
                }
                continue;
            };
            let good = |word: &str| {
                let number: Result<f64, _> = word.parse();
                number.is_ok_and(|x| if *infinite { !x.is_nan() } else { (x as f32).is_finite() })
            };
            let words: Vec<&str> = found.value().split_whitespace().collect();
            if words.len() != *count || !words.iter().all(|word| good(word)) {
                let problem = format!("found {:?}", found.value().chars().take(60).collect::<String>());
                return Err(self.source.error(found.range(), field(), problem, expected));
            }
        }
        Ok(())
    }

    /// The document without shapes, colours and what simulators add: nothing in them bears on dynamics, and a texture that
    /// `urdf-rs` cannot read should not keep an arm from loading.
    pub(super) fn essentials(&self) -> String {
        let beside = self.robot.children().filter(|node| !node.has_tag_name("link") && !node.has_tag_name("joint"));
        let within = self.links.iter().flat_map(|link| link.children().filter(|node| !node.has_tag_name("inertial")));
        let mut left_out: Vec<_> = beside.chain(within).filter(Node::is_element).map(|node| node.range()).collect();
        left_out.sort_unstable_by_key(|range| range.start);
        let mut text = String::new();
        let mut from = 0;
        for range in left_out {
            text.push_str(self.source.text.get(from..range.start).unwrap_or_default());
            from = range.end;
        }
        text.push_str(self.source.text.get(from..).unwrap_or_default());
        text
    }

    /// The `name` of a link or joint.
    fn name(&self, node: &Node<'a, 'a>, kind: &str) -> Result<&'a str, FileError> {
        node.attribute("name")
            .filter(|name| !name.is_empty())
            .ok_or_else(|| self.error(node, format!("{kind}.name"), "missing", format!("a name for the {kind}")))
    }

    /// Whether a link has a child element of this name.
    pub(super) fn has(&self, link: usize, name: &str) -> bool {
        child(&self.links[link], name).is_some()
    }

    /// An error at the opening tag of an element.
    pub(super) fn error(
        &self,
        node: &Node<'a, 'a>,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        let range = node.range();
        let text = self.source.text.get(range.clone()).unwrap_or_default();
        let tag = text.find('>').map_or(range.len(), |end| end + 1);
        self.source.error(range.start..range.start + tag, field, problem, expected)
    }

    /// An error at a child element, or at the element itself when the child is not there.
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

    /// An error about a link that is named but not there.
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
