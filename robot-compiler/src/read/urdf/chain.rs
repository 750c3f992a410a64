//! Choice of the joints that form the arm.

use super::description::{Description, UrdfJoint};
use super::markup::{Markup, child};
use super::moving::{moves, supported};
use crate::describe::cut::Ends;
use crate::describe::diagnostics::{FileError, listed, one_of};
use crate::describe::robot::DOF;
use dynamics_core::model::Placement;
use std::collections::HashMap;

/// Names of the command line's options in a scene file.
const IN_A_SCENE: &str = "in a scene: `tip`, `base`";

/// The arm inside a tree of links. Links and joints are indices in the order of the file.
pub(super) struct Chain {
    /// Moving joints, base first.
    pub(super) moving: Vec<usize>,
    /// Every joint's parent link.
    pub(super) parent: Vec<usize>,
    /// Every joint's child link.
    pub(super) child: Vec<usize>,
    /// The joint above a link; `None` for the root.
    pub(super) above: Vec<Option<usize>>,
    /// Joints below a link, in the order of the file.
    pub(super) below: Vec<Vec<usize>>,
    /// The base link of the arm.
    pub(super) base: usize,
    /// The link whose frame is the tip.
    pub(super) tip: usize,
    /// Moving joints outside the chain, held still.
    pub(super) held: Vec<usize>,
    /// Position of every joint that is held, rad or m: zero, or a mimic joint's position for zero of its leader.
    pub(super) position: Vec<f64>,
    /// `parent_from_child` of every held or fixed joint, and of every moving joint at zero.
    pub(super) place: Vec<Placement<f64>>,
}

impl Chain {
    pub(super) fn new(markup: &Markup<'_>, urdf: &Description<'_>, ends: Ends<'_>) -> Result<Self, FileError> {
        let mut chain = Self::tree(markup, urdf)?;
        let root = chain.root(markup, urdf)?;
        let find = |end: &str, name: &str| {
            let names: Vec<&str> = urdf.links.iter().map(|link| link.name).collect();
            let index = names.iter().position(|link| *link == name);
            index.ok_or_else(|| markup.unknown_link(&markup.robot, end, name, &names))
        };
        chain.base = ends.base.map_or(Ok(root), |name| find("base", name))?;
        chain.tip = match ends.tip {
            Some(name) => find("tip", name)?,
            None => chain.only_tip(markup, urdf)?,
        };
        if !chain.reaches(chain.tip, chain.base) {
            let (base, tip) = (&urdf.links[chain.base], &urdf.links[chain.tip]);
            let problem = format!("{:?} is not on the way from the root to the tip {:?}", base.name, tip.name);
            let above: Vec<&str> = chain.upwards(chain.tip).skip(1).map(|link| urdf.links[link].name).collect();
            let expected = format!("a link above the tip: {}", listed(&above));
            return Err(markup.error(&base.node, "base", problem, expected));
        }
        chain.moving = chain.moving_above(urdf, chain.tip);
        for &joint in &chain.moving {
            supported(markup, urdf, joint)?;
        }
        // Other moving joints are not part of the arm, but the arm carries those on its links.
        let base = chain.moving.first().map_or(chain.base, |&joint| chain.child[joint]);
        let carried = (0..urdf.joints.len()).filter(|&joint| moves(urdf, joint) && !chain.moving.contains(&joint));
        chain.held = carried.filter(|&joint| chain.is_below(joint, base)).collect();
        chain.place = urdf.joints.iter().map(|joint| joint.origin).collect();
        chain.position = vec![0.0; urdf.joints.len()];
        for joint in chain.held.clone() {
            let q = chain.held_at(markup, urdf, joint, 0)?;
            chain.position[joint] = q;
            chain.place[joint] = urdf.joints[joint].at(q);
        }
        Ok(chain)
    }

    /// Position of a held joint: zero, or `multiplier q + offset` of the joint that it follows.
    fn held_at(
        &self,
        markup: &Markup<'_>,
        urdf: &Description<'_>,
        joint: usize,
        depth: usize,
    ) -> Result<f64, FileError> {
        let UrdfJoint { node, name, .. } = &urdf.joints[joint];
        let Some(mimic) = child(node, "mimic") else { return Ok(0.0) };
        let label = format!("joint {name}");
        let error =
            |problem: String, expected: String| markup.error(&mimic, format!("{label}.mimic"), problem, expected);
        if depth > urdf.joints.len() {
            return Err(error(
                "the joints follow each other in a loop".to_owned(),
                "one joint that moves on its own".to_owned(),
            ));
        }
        let leader = mimic.attribute("joint").unwrap_or_default();
        let Some(index) = urdf.joints.iter().position(|joint| joint.name == leader) else {
            let names: Vec<&str> = urdf.joints.iter().map(|joint| joint.name).collect();
            return Err(error(format!("there is no joint {leader:?}"), one_of(leader, &names)));
        };
        let number =
            |key, otherwise| Ok::<f64, FileError>(markup.finite(&mimic, key, &label)?.map_or(otherwise, |[x]| x));
        let (multiplier, offset) = (number("multiplier", 1.0)?, number("offset", 0.0)?);
        let followed = if self.moving.contains(&index) { 0.0 } else { self.held_at(markup, urdf, index, depth + 1)? };
        Ok(multiplier * followed + offset)
    }

    /// Links by name, and the parent and child of every joint.
    fn tree(markup: &Markup<'_>, urdf: &Description<'_>) -> Result<Self, FileError> {
        let mut links: HashMap<&str, usize> = HashMap::new();
        for (index, link) in urdf.links.iter().enumerate() {
            if links.insert(link.name, index).is_some() {
                let problem = format!("{:?} names two links", link.name);
                return Err(markup.error(
                    &urdf.links[index].node,
                    "link.name",
                    problem,
                    "a name of its own for every link",
                ));
            }
        }
        let names: Vec<&str> = urdf.links.iter().map(|link| link.name).collect();
        let count = urdf.links.len();
        let mut chain = Self {
            moving: Vec::new(),
            parent: Vec::new(),
            child: Vec::new(),
            above: vec![None; count],
            below: vec![Vec::new(); count],
            base: 0,
            tip: 0,
            held: Vec::new(),
            position: Vec::new(),
            place: Vec::new(),
        };
        for (index, joint) in urdf.joints.iter().enumerate() {
            let node = &urdf.joints[index].node;
            if urdf.joints.iter().take(index).any(|before| before.name == joint.name) {
                let problem = format!("{:?} names two joints", joint.name);
                return Err(markup.error(node, "joint.name", problem, "a name of its own for every joint"));
            }
            let find = |end: &str, name: &str| {
                let field = format!("joint {}.{end}", joint.name);
                links.get(name).copied().ok_or_else(|| {
                    let element = child(node, end).unwrap_or(*node);
                    markup.unknown_link(&element, field, name, &names)
                })
            };
            let (parent, below) = (find("parent", joint.parent)?, find("child", joint.child)?);
            if let Some(other) = chain.above[below] {
                let problem = format!("{:?} already hangs on joint {:?}", joint.child, urdf.joints[other].name);
                let field = format!("joint {}.child", joint.name);
                return Err(markup.error_in(node, "child", field, problem, "one joint above every link"));
            }
            chain.parent.push(parent);
            chain.child.push(below);
            chain.above[below] = Some(index);
            chain.below[parent].push(index);
        }
        Ok(chain)
    }

    /// The root: the only link without a parent, from which every other can be reached.
    fn root(&self, markup: &Markup<'_>, urdf: &Description<'_>) -> Result<usize, FileError> {
        let roots: Vec<usize> = (0..urdf.links.len()).filter(|&link| self.above[link].is_none()).collect();
        let expected = "a tree: exactly one link without a joint above it";
        let root = match roots.as_slice() {
            [] => {
                let problem = if urdf.links.is_empty() { "there is no link" } else { "the joints form a loop" };
                return Err(markup.error(&markup.robot, "robot", problem, expected));
            }
            [root] => *root,
            [_, second, ..] => {
                let problem = format!("{} links hang on no joint, this one among them", roots.len());
                return Err(markup.error(&urdf.links[*second].node, "link", problem, expected));
            }
        };
        let looped = (0..urdf.links.len()).find(|&link| link != root && !self.reaches(link, root));
        match looped {
            None => Ok(root),
            Some(link) => Err(markup.error(&urdf.links[link].node, "link", "the joints above form a loop", expected)),
        }
    }

    /// A link and those above it, up to the root; stops if the links form a loop.
    fn upwards(&self, link: usize) -> impl Iterator<Item = usize> + '_ {
        let next = |&link: &usize| self.above[link].map(|joint| self.parent[joint]);
        std::iter::successors(Some(link), next).take(self.above.len() + 1)
    }

    fn reaches(&self, link: usize, root: usize) -> bool {
        self.upwards(link).any(|link| link == root)
    }

    /// Moving joints between the base and a link below it, base first.
    fn moving_above(&self, urdf: &Description<'_>, link: usize) -> Vec<usize> {
        let links = self.upwards(link).take_while(|&link| link != self.base);
        let mut moving: Vec<usize> =
            links.filter_map(|link| self.above[link]).filter(|&joint| moves(urdf, joint)).collect();
        moving.reverse();
        moving
    }

    /// Advice for a chain with too few or too many joints.
    pub(super) fn shorter(&self, urdf: &Description<'_>) -> String {
        let name = |joint: usize| urdf.links[self.child[joint]].name;
        let most = *DOF.end();
        match (self.moving.get(most - 1), self.moving.len().checked_sub(most + 1)) {
            (Some(&last), Some(first)) => format!(
                "a chain of one to six moving joints: end it earlier, as with `--tip {}`, or begin it later, as with `--base {}` \
                 ({IN_A_SCENE})",
                name(last),
                name(self.moving[first])
            ),
            _ => format!("a chain of one to six moving joints between `--base LINK` and `--tip LINK` ({IN_A_SCENE})"),
        }
    }

    /// True if a joint is between the root and a link.
    pub(super) fn is_above(&self, joint: usize, link: usize) -> bool {
        self.upwards(link).any(|link| self.above[link] == Some(joint))
    }

    /// True if a joint is a descendant of a link.
    pub(super) fn is_below(&self, joint: usize, link: usize) -> bool {
        self.reaches(self.parent[joint], link)
    }

    /// The tip if none is named: follows the only moving branch, then goes to the first fixed leaf.
    fn only_tip(&self, markup: &Markup<'_>, urdf: &Description<'_>) -> Result<usize, FileError> {
        let mut link = self.base;
        for _ in 0..=urdf.links.len() {
            let ways: Vec<usize> = self.below[link].iter().copied().filter(|&j| self.carries_motion(urdf, j)).collect();
            match ways.as_slice() {
                [] => break,
                [only] => link = self.child[*only],
                [first, second, ..] => {
                    let (a, b) = (&urdf.joints[*first].name, &urdf.joints[*second].name);
                    let problem =
                        format!("the tree branches at link {:?}: joints {a:?} and {b:?}", urdf.links[link].name);
                    let tips = self.tips(urdf, link);
                    let expected =
                        format!("one chain, or its tip with `--tip LINK` ({IN_A_SCENE}); the tips: {}", listed(&tips));
                    return Err(markup.error(&urdf.joints[*second].node, "joint", problem, expected));
                }
            }
        }
        for _ in 0..=urdf.links.len() {
            match self.below[link].first() {
                Some(&joint) => link = self.child[joint],
                None => break,
            }
        }
        Ok(link)
    }

    /// Links at which a chain through a branching link may end: that link, and the ends of its branches, each with its number
    /// of moving joints.
    fn tips(&self, urdf: &Description<'_>, branching: usize) -> Vec<String> {
        let ends = (0..urdf.links.len()).filter(|&link| self.below[link].is_empty() && self.reaches(link, branching));
        let named = |link: usize| match self.moving_above(urdf, link).len() {
            0 => None,
            1 => Some(format!("{} (1 joint)", urdf.links[link].name)),
            count => Some(format!("{} ({count} joints)", urdf.links[link].name)),
        };
        std::iter::once(branching).chain(ends).filter_map(named).collect()
    }

    /// True if a joint or anything below it moves.
    fn carries_motion(&self, urdf: &Description<'_>, joint: usize) -> bool {
        let mut open = vec![joint];
        while let Some(joint) = open.pop() {
            if moves(urdf, joint) {
                return true;
            }
            open.extend(&self.below[self.child[joint]]);
        }
        false
    }
}
