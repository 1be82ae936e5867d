//! The call stack, and what each call of a watched function costs.
//!
//! Every exception has a `Level` of its own: its own call stack and its own count, so that what it
//! does is no part of what it interrupts. What an instruction has done is known only when the next
//! one is seen: a conditional return may or may not have been taken, and an exception may stand
//! between the two.
//!
//! # An entry that nobody sees
//! Where time is counted in instructions, QEMU stops at an access to a device in the middle of a
//! block and begins that instruction again, without showing it a second time. An interrupt may come
//! first: then the instruction that was shown is not executed before it returns, and the handler's
//! first one is not shown. So a handler is also known by its second.

use crate::thumb::Flow;

/// An instruction of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Where it stands.
    pub address: u64,
    /// Where the next one in memory stands.
    pub next: u64,
    /// What it does to the call stack.
    pub flow: Flow,
    /// Whether an exception's handler begins here.
    pub is_handler: bool,
    /// The watched function that begins here, as its place in the list of them.
    pub function: Option<usize>,
    /// The first instruction of the handler of which this is the second, if that one leads here and
    /// nowhere else.
    pub entry: Option<&'static Instruction>,
}

/// What the calls of a function have cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Calls that have returned.
    pub calls: u64,
    /// Fewest instructions of a call.
    pub min: u64,
    /// Most instructions of a call.
    pub max: u64,
    /// Instructions of all calls.
    pub sum: u64,
    /// The first call that cost the most, counted from 0.
    pub max_call: u64,
}

impl Cost {
    fn add(&mut self, instructions: u64) {
        if self.calls == 0 || instructions < self.min {
            self.min = instructions;
        }
        if instructions > self.max {
            (self.max, self.max_call) = (instructions, self.calls);
        }
        self.sum += instructions;
        self.calls += 1;
    }
}

/// A call of a watched function that has not returned.
#[derive(Clone, Copy, Debug)]
struct Open {
    function: usize,
    /// The length of the call stack while it runs.
    depth: usize,
    /// The level's count before its first instruction.
    start: u64,
    /// Whether a way from here has come to its end: only its first end counts.
    has_arrived: bool,
}

/// The program, or an exception that interrupts it.
#[derive(Debug, Default)]
struct Level {
    /// The last instruction seen.
    last: Option<Instruction>,
    /// Where the calls that have not returned go on.
    return_addresses: Vec<u64>,
    open: Vec<Open>,
    /// Instructions seen.
    count: u64,
}

/// Counts what it is shown.
#[derive(Debug)]
pub struct Counter {
    /// Of the functions, then of the ways.
    costs: Vec<Cost>,
    functions: usize,
    ways: Vec<(usize, usize)>,
    /// What the level below was interrupted by, up to the running one.
    interrupted: Vec<Level>,
    level: Level,
    lost: Option<String>,
}

impl Counter {
    /// A counter for a number of watched functions and ways between them, before the image's first
    /// instruction.
    pub fn new(functions: usize, ways: Vec<(usize, usize)>) -> Self {
        Self {
            costs: vec![Cost::default(); functions + ways.len()],
            functions,
            ways,
            interrupted: Vec::new(),
            level: Level::default(),
            lost: None,
        }
    }

    /// What each function, and then each way, has cost so far.
    ///
    /// # Errors
    /// The call stack was lost; the message says where.
    pub fn costs(&self) -> Result<&[Cost], &str> {
        self.lost.as_deref().map_or(Ok(&self.costs), Err)
    }

    /// Takes the next instruction in, just before it is executed.
    pub fn see(&mut self, instruction: &Instruction) {
        if self.lost.is_some() {
            return;
        }
        if let Some(entry) = instruction.entry
            && self.level.last.is_none_or(|last| last.address != entry.address)
        {
            // The one that was shown last is yet to be executed.
            self.level.count = self.level.count.saturating_sub(1);
            self.level.last = None;
            self.see(entry);
        }
        if instruction.is_handler {
            self.interrupted.push(std::mem::take(&mut self.level));
        } else {
            self.arrive(instruction.address);
        }
        let level = &mut self.level;
        if let Some(function) = instruction.function {
            let depth = level.return_addresses.len();
            // A function may also jump back to its own beginning.
            if !level.open.iter().any(|open| open.function == function && open.depth == depth) {
                level.open.push(Open { function, depth, start: level.count, has_arrived: false });
            }
        }
        level.count += 1;
        level.last = Some(*instruction);
    }

    /// Concludes from the address that follows what the last instruction has done.
    fn arrive(&mut self, address: u64) {
        let Some(last) = self.level.last.filter(|last| last.next != address) else {
            return;
        };
        match last.flow {
            Flow::Call => self.level.return_addresses.push(last.next),
            Flow::Return => self.go_back(address),
            Flow::Jump | Flow::Other => {}
        }
    }

    fn go_back(&mut self, address: u64) {
        self.close();
        match self.level.return_addresses.pop() {
            Some(expected) if expected != address => {
                self.lost = Some(format!("return to {address:#x} instead of {expected:#x}"));
            }
            Some(_) => {}
            None => match self.interrupted.pop() {
                Some(below) => {
                    self.level = below;
                    self.arrive(address);
                }
                None => self.lost = Some(format!("return to {address:#x} without a call")),
            },
        }
    }

    /// Ends the calls of watched functions that end with the innermost call of the level, or with
    /// the level.
    fn close(&mut self) {
        let Level { open, return_addresses, count, .. } = &mut self.level;
        while let Some(call) = open.pop_if(|call| call.depth >= return_addresses.len()) {
            self.costs[call.function].add(*count - call.start);
            let ends = self.ways.iter().zip(&mut self.costs[self.functions..]);
            for (&(from, _), cost) in ends.filter(|((_, to), _)| *to == call.function) {
                let caller = open.iter_mut().rev().find(|caller| caller.function == from);
                if let Some(caller) = caller.filter(|caller| !caller.has_arrived) {
                    caller.has_arrived = true;
                    cost.add(*count - caller.start);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cost, Counter, Instruction};
    use crate::thumb::Flow;

    /// The watched function of most tests.
    const WATCHED: u64 = 0x100;
    /// An exception's handler, watched too.
    const HANDLER: u64 = 0x200;
    const OTHER_HANDLER: u64 = 0x300;

    /// The first instruction of the handler.
    static ENTRY: Instruction = Instruction {
        address: HANDLER,
        next: HANDLER + 2,
        flow: Flow::Other,
        is_handler: true,
        function: Some(1),
        entry: None,
    };

    /// Executes instructions of 2 bytes at these addresses.
    fn run(path: &[(u64, Flow)]) -> Counter {
        let mut counter = Counter::new(2, vec![(1, 0)]);
        let leads_on = path.iter().all(|&(address, flow)| address != HANDLER || flow == Flow::Other);
        for &(address, flow) in path {
            counter.see(&Instruction {
                address,
                next: address + 2,
                flow,
                is_handler: matches!(address, HANDLER | OTHER_HANDLER),
                function: [WATCHED, HANDLER].iter().position(|&entry| entry == address),
                entry: (leads_on && address == ENTRY.next).then_some(&ENTRY),
            });
        }
        counter
    }

    fn cost(counter: &Counter, function: usize) -> Cost {
        counter.costs().expect("the call stack is not lost")[function]
    }

    /// Calls, and instructions of all calls.
    fn calls_and_sum(counter: &Counter, function: usize) -> (u64, u64) {
        let Cost { calls, sum, .. } = cost(counter, function);
        (calls, sum)
    }

    const CALL: Flow = Flow::Call;
    const RETURN: Flow = Flow::Return;
    const OTHER: Flow = Flow::Other;

    #[test]
    fn a_call_counts_from_the_first_instruction_to_the_return() {
        let counter = run(&[(0, CALL), (WATCHED, OTHER), (0x102, OTHER), (0x104, RETURN), (2, OTHER)]);
        assert_eq!(calls_and_sum(&counter, 0), (1, 3));
    }

    #[test]
    fn a_call_that_has_not_returned_does_not_count() {
        let counter = run(&[(0, CALL), (WATCHED, OTHER), (0x102, RETURN)]);
        assert_eq!(calls_and_sum(&counter, 0), (0, 0));
    }

    #[test]
    fn fewest_most_and_the_first_call_with_the_most_are_told() {
        let once = |length: u64| {
            let body = (0..length - 1).map(|i| (WATCHED + 2 * i, OTHER));
            [(0, CALL)].into_iter().chain(body).chain([(0x180, RETURN), (2, OTHER)])
        };
        let path: Vec<_> = [5, 3, 9, 9, 4].into_iter().flat_map(once).collect();
        let expected = Cost { calls: 5, min: 3, max: 9, sum: 30, max_call: 2 };
        assert_eq!(cost(&run(&path), 0), expected);
    }

    #[test]
    fn what_a_function_calls_is_part_of_it() {
        let inner = [(0x40, OTHER), (0x42, RETURN)];
        let path = [&[(0, CALL), (WATCHED, CALL)], &inner[..], &[(0x102, RETURN), (2, OTHER)]].concat();
        assert_eq!(calls_and_sum(&run(&path), 0), (1, 4));
    }

    #[test]
    fn a_tail_call_is_part_of_the_function_and_returns_for_it() {
        let counter = run(&[(0, CALL), (WATCHED, OTHER), (0x40, OTHER), (0x42, RETURN), (2, OTHER)]);
        assert_eq!(calls_and_sum(&counter, 0), (1, 3));
    }

    #[test]
    fn a_function_entered_by_a_tail_call_ends_with_its_caller() {
        let counter = run(&[(0, CALL), (0x40, OTHER), (WATCHED, OTHER), (0x102, RETURN), (2, OTHER)]);
        assert_eq!(calls_and_sum(&counter, 0), (1, 2));
    }

    #[test]
    fn a_jump_back_to_the_beginning_is_no_call() {
        let counter = run(&[(0, CALL), (WATCHED, OTHER), (WATCHED, OTHER), (0x102, RETURN), (2, OTHER)]);
        assert_eq!(calls_and_sum(&counter, 0), (1, 3));
    }

    #[test]
    fn recursive_calls_count_each() {
        let nested = [(WATCHED, OTHER), (0x102, RETURN)];
        let path = [&[(0, CALL), (WATCHED, CALL)], &nested[..], &[(0x102, RETURN), (2, OTHER)]].concat();
        assert_eq!(calls_and_sum(&run(&path), 0), (2, 6), "2 of the inner call, 4 of the outer one");
    }

    #[test]
    fn a_conditional_return_that_is_not_taken_is_none() {
        let counter = run(&[(0, CALL), (WATCHED, RETURN), (0x102, OTHER), (0x104, RETURN), (2, OTHER)]);
        assert_eq!(calls_and_sum(&counter, 0), (1, 3));
    }

    #[test]
    fn an_exception_is_no_part_of_what_it_interrupts() {
        let interruption = [(HANDLER, CALL), (0x40, RETURN), (0x202, RETURN)];
        let path =
            [&[(0, CALL), (WATCHED, OTHER)], &interruption[..], &[(0x102, RETURN), (2, OTHER)]].concat();
        let counter = run(&path);
        assert_eq!(calls_and_sum(&counter, 0), (1, 2));
        assert_eq!(calls_and_sum(&counter, 1), (1, 3));
    }

    #[test]
    fn an_exception_whose_entry_is_not_seen_comes_before_the_instruction_that_was() {
        let again = [(WATCHED, OTHER), (0x202, CALL), (0x40, RETURN), (0x204, RETURN), (WATCHED, OTHER)];
        let path = [&[(0, CALL)], &again[..], &[(0x102, RETURN), (2, OTHER)]].concat();
        let counter = run(&path);
        assert_eq!(calls_and_sum(&counter, 0), (1, 2));
        assert_eq!(calls_and_sum(&counter, 1), (1, 4), "with the one that was not seen");
    }

    #[test]
    fn an_exception_between_a_call_and_the_function_changes_nothing() {
        let path =
            [(0, CALL), (HANDLER, RETURN), (WATCHED, OTHER), (0x102, RETURN), (HANDLER, RETURN), (2, OTHER)];
        assert_eq!(calls_and_sum(&run(&path), 0), (1, 2));
    }

    #[test]
    fn an_exception_that_follows_another_at_once_is_no_part_of_it() {
        let chained = [(HANDLER, OTHER), (0x202, RETURN), (OTHER_HANDLER, OTHER), (0x302, RETURN)];
        let path = [&[(0, CALL), (WATCHED, OTHER)], &chained[..], &[(0x102, RETURN), (2, OTHER)]].concat();
        let counter = run(&path);
        assert_eq!(calls_and_sum(&counter, 0), (1, 2));
        assert_eq!(calls_and_sum(&counter, 1), (1, 2));
    }

    #[test]
    fn a_way_counts_from_the_begin_of_a_function_to_the_first_return_of_another_that_it_calls() {
        let once = [(HANDLER, CALL), (WATCHED, OTHER), (0x102, RETURN)];
        let path = [&once[..], &[(0x202, CALL), (WATCHED, RETURN), (0x204, RETURN), (2, OTHER)]].concat();
        let counter = run(&[&[(0, OTHER)], &path[..]].concat());
        assert_eq!(calls_and_sum(&counter, 0), (2, 3));
        assert_eq!(calls_and_sum(&counter, 2), (1, 3), "not to the second return");
    }

    #[test]
    fn a_return_to_another_place_than_that_of_the_call_voids_the_figures() {
        let counter = run(&[(0, CALL), (WATCHED, RETURN), (0x40, OTHER)]);
        assert_eq!(counter.costs(), Err("return to 0x40 instead of 0x2"));
        assert_eq!(run(&[(0, RETURN), (0x40, OTHER)]).costs(), Err("return to 0x40 without a call"));
    }
}
