//! Worst-case stack depth of a program, from its instructions and its vector table.
//!
//! A function's frame is the sum of everything that its instructions subtract from the stack pointer, anywhere in it. To this is added the deepest of
//! the functions that it calls or jumps to. A call through a register may go to every function with an address that the program contains as a number.
//! Recursive functions are counted once each and listed by name; the reader must check separately that they do not recurse deeper. All interrupt
//! handlers can be nested, each once, with the registers that the core saves on entry, because an interrupt waits while it is served. They are added
//! to the stack that is in use once interrupts are unmasked ([`Stack::open`]). A hard fault is not part of the sum, because nothing runs after it.

use crate::decode::Effect;
use crate::elf::{ImageError, Program};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Bytes that the core pushes on entry to an interrupt: 26 words with the float unit's registers, and one for alignment (Arm v7-M Architecture
/// Reference Manual, B1.5.7).
pub const EXCEPTION_FRAME: u64 = 4 * 27;

/// Worst-case stack depth of one entry function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Depth {
    /// The entry function: the program's start, or a handler.
    pub name: String,
    /// Depth in bytes, including the exception frame if the core pushes one.
    pub bytes: u64,
}

/// Worst-case stack depth of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stack {
    /// Depth of each entry: the program's start first, then each handler.
    pub entries: Vec<Depth>,
    /// Bytes used by the start while interrupts are not masked. This is all of the start's depth, unless `main` masks interrupts and one function
    /// that it calls unmasks them, as RTIC does after `init`. Whatever that function calls before is assumed to leave the mask unchanged, as critical
    /// sections do; a trace of the emulated chip checks it.
    pub open: u64,
    /// Recursive functions, counted once each.
    pub recursive: Vec<String>,
    /// Functions with calls through a register. Such a call may go to any function with an address that is a number in the program.
    pub indirect: Vec<String>,
    /// Functions that set the stack pointer from a register; that part is not in the sum.
    pub unknown: Vec<String>,
}

impl Stack {
    /// Total bytes: the depth of the start alone, or its depth with interrupts unmasked plus all nested handlers, whichever is larger.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let [start, handlers @ ..] = self.entries.as_slice() else { return 0 };
        let handlers: u64 = handlers.iter().map(|entry| entry.bytes).sum();
        start.bytes.max(self.open + handlers)
    }
}

/// Bytes that a function subtracts from the stack pointer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Taken {
    /// Sum over its instructions, bytes.
    bytes: u64,
    /// True if an instruction sets the stack pointer from a register, or subtracts a register from it.
    unknown: bool,
}

/// A function as a node of the call graph.
#[derive(Default)]
struct Node {
    frame: u64,
    calls: BTreeSet<u32>,
}

/// The call graph that is reachable from the entries.
#[derive(Default)]
struct Graph {
    nodes: BTreeMap<u32, Node>,
    depths: BTreeMap<u32, u64>,
}

impl Graph {
    /// All functions reachable from one; the function itself is included only if it is recursive.
    fn reached(&self, from: u32) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        let mut open = vec![from];
        while let Some(node) = open.pop().and_then(|at| self.nodes.get(&at)) {
            open.extend(node.calls.iter().filter(|call| found.insert(**call)));
        }
        found
    }

    /// A function and all members of its recursion.
    fn circle(&self, of: u32) -> BTreeSet<u32> {
        let mut circle: BTreeSet<u32> =
            self.reached(of).into_iter().filter(|other| self.reached(*other).contains(&of)).collect();
        circle.insert(of);
        circle
    }

    /// Worst-case stack depth of a function, including its own frame.
    fn depth(&mut self, of: u32) -> u64 {
        if let Some(known) = self.depths.get(&of) {
            return *known;
        }
        let circle = self.circle(of);
        let inside = |at: &u32| self.nodes.get(at);
        let own: u64 = circle.iter().filter_map(inside).map(|node| node.frame).sum();
        let out: BTreeSet<u32> = circle
            .iter()
            .filter_map(inside)
            .flat_map(|node| &node.calls)
            .filter(|at| !circle.contains(at))
            .copied()
            .collect();
        let below = out.into_iter().map(|next| self.depth(next)).max().unwrap_or(0);
        for at in circle {
            self.depths.insert(at, own + below);
        }
        own + below
    }
}

impl Program {
    /// Computes the worst-case depth of this program's stack: from its start, with all handlers of its vector table nested on top.
    ///
    /// # Errors
    /// The program has no vector table, or one of its functions is not known.
    pub fn stack(&self) -> Result<Stack, ImageError> {
        // The hard fault's handler is left out: it never returns, and the firmware's own starts with a fresh stack.
        let [_, start, unmaskable, _hard_fault, handlers @ ..] = self.vectors.as_slice() else {
            return Err(ImageError::NoVectors);
        };
        let handlers: BTreeSet<u32> =
            handlers.iter().chain([unmaskable]).filter(|at| **at != 0).map(|at| at & !1).collect();
        let start = start & !1;
        let mut stack = Stack::default();
        let mut graph = Graph::default();
        let addresses = self.addresses_taken()?;
        let mut open: Vec<u32> = std::iter::once(start).chain(handlers.iter().copied()).collect();
        while let Some(at) = open.pop() {
            if graph.nodes.contains_key(&at) {
                continue;
            }
            let node = self.node(at, &addresses, &mut stack)?;
            open.extend(&node.calls);
            graph.nodes.insert(at, node);
        }
        for at in graph.nodes.keys().filter(|at| graph.reached(**at).contains(at)) {
            stack.recursive.push(self.name_of(*at));
        }
        stack.entries.push(Depth { name: self.name_of(start), bytes: graph.depth(start) });
        stack.open = self.open(start, &mut graph);
        for at in handlers {
            stack.entries.push(Depth { name: self.name_of(at), bytes: EXCEPTION_FRAME + graph.depth(at) });
        }
        Ok(stack)
    }

    fn node(&self, at: u32, addresses: &BTreeSet<u32>, stack: &mut Stack) -> Result<Node, ImageError> {
        let range = self.range(at)?;
        let taken = self.taken(range.clone());
        let found = self.references(range);
        let mut calls = BTreeSet::new();
        for goal in found.jumps {
            calls.insert(self.containing(goal).ok_or(ImageError::NoFunction(goal))?);
        }
        // The linker's veneers from flash to RAM contain their target as a number, and jump there through a register.
        let own: Vec<u32> = found.numbers.iter().filter_map(|number| self.function_at(*number)).collect();
        if found.indirect > 0 || (found.onward > 0 && own.is_empty()) {
            calls.extend(addresses);
            stack.indirect.push(self.name_of(at));
        }
        calls.extend(own);
        if taken.unknown {
            stack.unknown.push(self.name_of(at));
        }
        Ok(Node { frame: taken.bytes, calls })
    }

    /// Sum of the bytes that the instructions in a range subtract from the stack pointer; bytes that are returned are not deducted.
    fn taken(&self, range: Range<u32>) -> Taken {
        let mut all = Taken::default();
        for instruction in self.instructions(range) {
            if let Effect::Push(bytes) = instruction.effect {
                all.bytes += u64::from(bytes);
            }
            all.unknown |= instruction.moves_stack_freely();
        }
        all
    }

    /// Every function whose address is a number in the program, except those of the vector table.
    fn addresses_taken(&self) -> Result<BTreeSet<u32>, ImageError> {
        let mut taken = BTreeSet::new();
        for start in self.functions.keys() {
            let found = self.references(self.range(*start)?);
            taken.extend(found.numbers.iter().filter_map(|number| self.function_at(*number)));
        }
        for section in self.sections.iter().filter(|section| !section.executable && section.address != self.vectors_at)
        {
            taken.extend(section.words().filter_map(|word| self.function_at(word)));
        }
        Ok(taken)
    }

    /// Depth below the start while interrupts are not masked: see [`Stack::open`].
    fn open(&self, start: u32, graph: &mut Graph) -> u64 {
        let callees = |of: u32| graph.nodes.get(&of).into_iter().flat_map(|node| &node.calls).copied();
        let masks = |at: &u32| self.change_of_mask(*at, true).is_some() && self.change_of_mask(*at, false).is_none();
        let mut unmask = Vec::new();
        for main in callees(start).filter(masks) {
            let openers: Vec<_> = callees(main).filter_map(|at| Some((at, self.change_of_mask(at, false)?))).collect();
            // Nothing may run in `main` after the function that unmasks.
            let rest = callees(main).filter(|at| openers.iter().all(|(opener, _)| opener != at));
            if !openers.is_empty() && rest.count() == 0 {
                unmask.extend(openers.into_iter().map(|(opener, from)| (main, opener, from)));
            }
        }
        let frame = |graph: &Graph, at: u32| graph.nodes.get(&at).map_or(0, |node| node.frame);
        let [(main, opener, from)] = unmask[..] else { return graph.depth(start) };
        let Ok(range) = self.range(opener) else { return graph.depth(start) };
        let behind = self.references(self.back(range.clone(), from)..range.end);
        if behind.indirect > 0 || behind.onward > 0 {
            return graph.depth(start);
        }
        let goals: BTreeSet<u32> =
            behind.jumps.into_iter().filter_map(|goal| self.containing(goal)).filter(|at| *at != opener).collect();
        let below = goals.into_iter().map(|at| graph.depth(at)).max().unwrap_or(0);
        frame(graph, start) + frame(graph, main) + frame(graph, opener) + below
    }

    /// Address at which a function first masks or unmasks all interrupts with its own instruction.
    fn change_of_mask(&self, function: u32, masks: bool) -> Option<u32> {
        let range = self.range(function).ok()?;
        self.instructions(range).find(|found| found.effect == Effect::Mask(masks)).map(|found| found.address)
    }

    /// Lowest address of a function that can run after the instruction at `from`: that address, or the target of a later jump backward.
    fn back(&self, range: Range<u32>, mut from: u32) -> u32 {
        loop {
            let goals = self.instructions(from..range.end).filter_map(|found| match found.effect {
                Effect::Jump(goal) if range.contains(&goal) && goal < from => Some(goal),
                _ => None,
            });
            match goals.min() {
                Some(goal) => from = goal,
                None => return from,
            }
        }
    }

    fn name_of(&self, at: u32) -> String {
        self.functions.get(&at).map_or_else(|| format!("{at:#x}"), |(name, _)| name.clone())
    }
}

#[cfg(test)]
mod tests;
