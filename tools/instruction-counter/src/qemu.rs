//! QEMU's plugin interface, version 1, as far as it is used here.
//!
//! Names and signatures are those of `qemu-plugin.h`. The emulator calls everything below from one
//! thread, since the board has one processor; the lock is for the compiler, and for a QEMU that
//! would use more.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::fmt::Write as _;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use crate::arguments::Arguments;
use crate::counter::{Cost, Counter, Instruction};
use crate::thumb::Flow;

type PluginId = u64;

/// A translated block of instructions; QEMU's own.
#[repr(C)]
struct Block([u8; 0]);

/// An instruction of a translated block; QEMU's own.
#[repr(C)]
struct BlockInstruction([u8; 0]);

/// `QEMU_PLUGIN_CB_NO_REGS`: a callback reads no registers.
const NO_REGISTERS: c_int = 0;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: PluginId, callback: extern "C" fn(PluginId, *mut Block));
    fn qemu_plugin_register_atexit_cb(
        id: PluginId,
        callback: extern "C" fn(PluginId, *mut c_void),
        data: *mut c_void,
    );
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut BlockInstruction;
    fn qemu_plugin_insn_vaddr(instruction: *const BlockInstruction) -> u64;
    fn qemu_plugin_insn_size(instruction: *const BlockInstruction) -> usize;
    fn qemu_plugin_insn_data(instruction: *const BlockInstruction) -> *const u8;
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut BlockInstruction,
        callback: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
}

/// All that the plugin keeps.
struct Plugin {
    arguments: Arguments,
    counter: Counter,
    /// By address. They live as long as the emulator, which holds pointers to them.
    instructions: HashMap<u64, &'static Instruction>,
}

static PLUGIN: OnceLock<Mutex<Plugin>> = OnceLock::new();

/// The plugin, once it is installed.
fn plugin() -> Option<MutexGuard<'static, Plugin>> {
    PLUGIN.get().map(|plugin| plugin.lock().unwrap_or_else(PoisonError::into_inner))
}

/// The version of the interface that the plugin is written for.
// SAFETY: QEMU looks it up by this name and reads an `int`.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

/// Starts the plugin; what is not 0 ends the emulator.
///
/// # Safety
/// QEMU calls it, with `count` arguments that are strings and live until it returns.
// SAFETY: QEMU looks it up by this name and calls it with these parameters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: PluginId,
    _info: *const c_void,
    count: c_int,
    arguments: *const *const c_char,
) -> c_int {
    let texts: Vec<_> = (0..usize::try_from(count).unwrap_or(0))
        // SAFETY: by this function's contract there are `count` pointers, each to a string.
        .map(|i| unsafe { CStr::from_ptr(*arguments.add(i)) }.to_string_lossy())
        .collect();
    let arguments = match Arguments::parse(texts.iter().map(AsRef::as_ref)) {
        Ok(arguments) => arguments,
        Err(problem) => {
            eprintln!("instruction-counter: {problem}");
            return 1;
        }
    };
    let counter = Counter::new(arguments.functions.len(), arguments.ways.clone());
    if PLUGIN.set(Mutex::new(Plugin { arguments, counter, instructions: HashMap::new() })).is_err() {
        eprintln!("instruction-counter: is there already");
        return 1;
    }
    // SAFETY: `id` is the one of this plugin; the callbacks have the types that QEMU calls them by.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
        qemu_plugin_register_atexit_cb(id, finish, std::ptr::null_mut());
    }
    0
}

/// QEMU has translated a block: asks for a callback before each of its instructions.
extern "C" fn translate(_: PluginId, block: *mut Block) {
    let Some(mut plugin) = plugin() else { return };
    // SAFETY: QEMU hands over a block that is valid during this call, and so are its instructions;
    // indices stay below their number. The data given away are of `execute`'s type and live for
    // ever.
    unsafe {
        for index in 0..qemu_plugin_tb_n_insns(block) {
            let handle = qemu_plugin_tb_get_insn(block, index);
            let address = qemu_plugin_insn_vaddr(handle);
            let encoding =
                std::slice::from_raw_parts(qemu_plugin_insn_data(handle), qemu_plugin_insn_size(handle));
            let data: *const Instruction = plugin.instruction(address, encoding);
            qemu_plugin_register_vcpu_insn_exec_cb(handle, execute, NO_REGISTERS, data.cast_mut().cast());
        }
    }
}

/// An instruction is about to be executed.
extern "C" fn execute(_: c_uint, data: *mut c_void) {
    // SAFETY: `translate` registers this callback, with a pointer to an instruction that lives for
    // ever and that nobody writes to.
    let instruction: &Instruction = unsafe { &*data.cast_const().cast() };
    if let Some(mut plugin) = plugin() {
        plugin.counter.see(instruction);
    }
}

/// The emulator ends: writes the results.
extern "C" fn finish(_: PluginId, _: *mut c_void) {
    let Some(plugin) = plugin() else { return };
    let out = &plugin.arguments.out;
    if let Err(error) = std::fs::write(out, plugin.results()) {
        eprintln!("instruction-counter: cannot write {}: {error}", out.display());
    }
}

impl Plugin {
    /// The one instruction at an address, however often its block is translated.
    fn instruction(&mut self, address: u64, encoding: &[u8]) -> &'static Instruction {
        let Self { arguments, instructions, .. } = self;
        if let Some(known) = instructions.get(&address) {
            return known;
        }
        // QEMU translates a handler's first instruction before its second.
        let leads_here = |first: &&Instruction| first.next == address && first.flow == Flow::Other;
        let first = |handler| instructions.get(handler).copied().filter(leads_here);
        let instruction: &Instruction = Box::leak(Box::new(Instruction {
            address,
            next: address + encoding.len() as u64,
            flow: Flow::of(encoding),
            is_handler: arguments.handlers.contains(&address),
            function: arguments.functions.iter().position(|function| function.address == address),
            entry: arguments.handlers.iter().find_map(first),
        }));
        instructions.insert(address, instruction);
        instruction
    }

    fn results(&self) -> String {
        match self.counter.costs() {
            Err(problem) => format!("lost {problem}\n"),
            Ok(costs) => {
                let mut text = String::new();
                let Arguments { functions, ways, .. } = &self.arguments;
                let of_ways = ways.iter().map(|&(_, to)| format!("to_{}", functions[to].name));
                let names = functions.iter().map(|function| function.name.clone()).chain(of_ways);
                for (name, Cost { calls, min, max, sum, max_call }) in names.zip(costs) {
                    // Writing to a string cannot fail.
                    let _ = writeln!(text, "{name} {calls} {min} {max} {sum} {max_call}");
                }
                text
            }
        }
    }
}
