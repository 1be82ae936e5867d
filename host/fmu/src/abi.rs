//! FMI's functions, as the standard's C headers declare them (FMI 3.0). Importers look all of them up,
//! those too that a unit for co-simulation does not have.
//!
//! # Safety
//! A caller keeps what the standard asks of it: an instance is one that an instantiation has
//! returned and that is not yet freed, a state one of that instance, and an array is as long as its
//! count says. Null is refused where it stands for no array. A panic becomes the status `Fatal`.
#![allow(non_snake_case, reason = "the names are those of the standard")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr::null_mut;
use std::slice;

use export::fmu::Unit;

use crate::instance::{Instance, Mode, State};

/// What a function answers.
#[repr(C)]
#[derive(Clone, Copy)]
enum Status {
    Ok = 0,
    Error = 3,
    Fatal = 4,
}

type LogMessage = Option<unsafe extern "C" fn(*const c_void, Status, *const c_char, *const c_char)>;

/// What an instance's pointer points at.
struct Handle {
    instance: Instance,
    environment: *const c_void,
    log: LogMessage,
}

fn say(environment: *const c_void, log: LogMessage, status: Status, message: &str) {
    let (Some(log), Ok(message)) = (log, CString::new(message.replace('\0', " "))) else { return };
    // SAFETY: both texts live until the call returns.
    unsafe { log(environment, status, c"error".as_ptr(), message.as_ptr()) }
}

/// Does some work on an instance.
///
/// # Safety
/// See the module.
unsafe fn with(handle: *mut c_void, work: impl FnOnce(&mut Instance) -> Result<(), String>) -> Status {
    // SAFETY: the caller's instance, which nobody else has at the same time.
    let Some(Handle { instance, environment, log }) = (unsafe { handle.cast::<Handle>().as_mut() }) else {
        return Status::Error;
    };
    let (status, message) = match catch_unwind(AssertUnwindSafe(|| work(instance))) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(message)) => (Status::Error, message),
        Err(_) => (Status::Fatal, "the model has ended within a step; please report this".to_owned()),
    };
    say(*environment, *log, status, &message);
    status
}

/// What a call from another mode is told.
fn only_in(instance: &Instance, modes: &[Mode], what: &str) -> Result<(), String> {
    let mode = instance.state.mode;
    if modes.contains(&mode) { Ok(()) } else { Err(format!("{what} is not possible in mode {mode:?}")) }
}

/// An array of a caller.
///
/// # Safety
/// See the module.
unsafe fn array<'a, T>(first: *const T, count: usize) -> Result<&'a [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err("an array is null".to_owned()),
        // SAFETY: it is as long as its count says.
        _ => Ok(unsafe { slice::from_raw_parts(first, count) }),
    }
}

/// An array of a caller, to be written.
///
/// # Safety
/// See the module.
unsafe fn array_mut<'a, T>(first: *mut T, count: usize) -> Result<&'a mut [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err("an array is null".to_owned()),
        // SAFETY: it is as long as its count says.
        _ => Ok(unsafe { slice::from_raw_parts_mut(first, count) }),
    }
}

/// Writes where a caller wants to know.
///
/// # Safety
/// See the module.
unsafe fn tell<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: a place of that type.
        unsafe { place.write(value) }
    }
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// There are no categories of messages: errors are always said.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut c_void,
    _is_on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> Status {
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, |_| Ok(())) }
}

#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "the standard's")]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _is_visible: bool,
    _logs: bool,
    _has_event_mode: bool,
    _may_return_early: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *const c_void,
    log: LogMessage,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let text = |text: *const c_char, what: &str| match text.is_null() {
        true => Err(format!("there is no {what}")),
        // SAFETY: a text that ends with 0.
        false => unsafe { CStr::from_ptr(text) }.to_str().map_err(|_| format!("the {what} is not UTF-8")),
    };
    let made = catch_unwind(AssertUnwindSafe(|| {
        let (token, resources) = (text(token, "instantiation token")?, text(resources, "path of resources")?);
        let unit = Unit::read(Path::new(resources)).map_err(|error| error.to_string())?;
        if unit.token != token {
            return Err("the resources are not those that the unit was exported with".to_owned());
        }
        Instance::new(&unit)
    }));
    match made.unwrap_or_else(|_| Err("the unit cannot be made; please report this".to_owned())) {
        Ok(instance) => Box::into_raw(Box::new(Handle { instance, environment, log })).cast(),
        Err(message) => {
            say(environment, log, Status::Error, &message);
            null_mut()
        }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: an instance that is not yet freed.
        drop(unsafe { Box::from_raw(instance.cast::<Handle>()) });
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
    _has_stop: bool,
    _stop_s: f64,
) -> Status {
    let enter = |instance: &mut Instance| {
        only_in(instance, &[Mode::Instantiated], "initialisation")?;
        if !start_s.is_finite() {
            return Err(format!("the start time {start_s} is no finite number"));
        }
        instance.begin(start_s);
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, enter) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> Status {
    let exit = |instance: &mut Instance| {
        only_in(instance, &[Mode::Initializing], "the end of initialisation")?;
        instance.initialize()
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, exit) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> Status {
    let end = |instance: &mut Instance| {
        only_in(instance, &[Mode::Stepping], "the end")?;
        instance.state.mode = Mode::Terminated;
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, end) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> Status {
    let reset = |instance: &mut Instance| {
        instance.reset();
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, reset) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    let get = |instance: &mut Instance| {
        // SAFETY: as the caller keeps it.
        let (references, values) = unsafe { (array(references, count)?, array_mut(values, value_count)?) };
        pair(references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            *value = instance.get(*reference)?;
        }
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, get) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    let set = |instance: &mut Instance| {
        // SAFETY: as the caller keeps it.
        let (references, values) = unsafe { (array(references, count)?, array(values, value_count)?) };
        pair(references.len(), values.len())?;
        references.iter().zip(values).try_for_each(|(reference, value)| instance.set(*reference, *value))
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, set) }
}

fn pair(references: usize, values: usize) -> Result<(), String> {
    if references == values {
        Ok(())
    } else {
        Err(format!("{references} variables and {values} values: every variable has one"))
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, place: *mut *mut c_void) -> Status {
    let get = |instance: &mut Instance| {
        // SAFETY: FMI has the caller pass a valid place that holds null or a state of ours, which is
        // overwritten.
        let place = unsafe { place.as_mut() }.ok_or("there is no place for the state")?;
        // SAFETY: as above.
        match unsafe { place.cast::<State>().as_mut() } {
            Some(state) => state.clone_from(&instance.state),
            None => *place = Box::into_raw(Box::new(instance.state.clone())).cast(),
        }
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, get) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *const c_void) -> Status {
    // SAFETY: as the caller keeps it.
    unsafe {
        with(instance, |instance| {
            instance.state = given(state)?.clone();
            Ok(())
        })
    }
}

/// A state of a caller.
///
/// # Safety
/// See the module.
unsafe fn given<'a>(state: *const c_void) -> Result<&'a State, String> {
    // SAFETY: as the caller keeps it.
    unsafe { state.cast::<State>().as_ref() }.ok_or_else(|| "there is no state".to_owned())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeFMUState(instance: *mut c_void, place: *mut *mut c_void) -> Status {
    let free = |_: &mut Instance| {
        // SAFETY: as the caller keeps it.
        if let Some(place) = unsafe { place.as_mut() }.filter(|place| !place.is_null()) {
            // SAFETY: a state that is not yet freed.
            drop(unsafe { Box::from_raw(place.cast::<State>()) });
            *place = null_mut();
        }
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, free) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut c_void,
    state: *const c_void,
    size: *mut usize,
) -> Status {
    // SAFETY: as the caller keeps it.
    unsafe {
        with(instance, |instance| {
            tell(size, instance.serialized(given(state)?)?.len());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut c_void,
    state: *const c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    let serialize = |instance: &mut Instance| {
        // SAFETY: as the caller keeps it.
        let (state, place) = unsafe { (given(state)?, array_mut(bytes, size)?) };
        let serialized = instance.serialized(state)?;
        let found = place.len();
        let place = place.get_mut(..serialized.len());
        let place = place.ok_or_else(|| format!("the state has {} bytes, not {found}", serialized.len()))?;
        place.copy_from_slice(&serialized);
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, serialize) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut c_void,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> Status {
    let deserialize = |instance: &mut Instance| {
        // SAFETY: as the caller keeps it.
        let (bytes, place) = unsafe { (array(bytes, size)?, place.as_mut()) };
        let place = place.ok_or("there is no place for the state")?;
        let found = instance.deserialized(bytes)?;
        // SAFETY: the place holds null or a state of ours, which is overwritten.
        match unsafe { place.cast::<State>().as_mut() } {
            Some(state) => *state = found,
            None => *place = Box::into_raw(Box::new(found)).cast(),
        }
        Ok(())
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, deserialize) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    from_s: f64,
    step_s: f64,
    _keeps_no_state: bool,
    needs_events: *mut bool,
    ends: *mut bool,
    is_early: *mut bool,
    reached_s: *mut f64,
) -> Status {
    let step = |instance: &mut Instance| {
        only_in(instance, &[Mode::Stepping], "a step")?;
        let done = instance.step(from_s, step_s);
        // SAFETY: as the caller keeps it.
        unsafe {
            for place in [needs_events, ends, is_early] {
                tell(place, false);
            }
            tell(reached_s, instance.time_s());
        }
        done
    };
    // SAFETY: as the caller keeps it.
    unsafe { with(instance, step) }
}

/// Functions of the standard that a unit without such variables, derivatives or modes refuses.
macro_rules! refused {
    ($($name:ident($($argument:ty),*): $why:literal;)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(instance: *mut c_void, $(_: $argument),*) -> Status {
            // SAFETY: as the caller keeps it.
            unsafe { with(instance, |_| Err(format!("{}: {}", stringify!($name), $why))) }
        }
    )*};
}

type References = *const u32;

refused! {
    fmi3GetFloat32(References, usize, *mut f32, usize): "all variables are Float64";
    fmi3GetInt8(References, usize, *mut i8, usize): "all variables are Float64";
    fmi3GetUInt8(References, usize, *mut u8, usize): "all variables are Float64";
    fmi3GetInt16(References, usize, *mut i16, usize): "all variables are Float64";
    fmi3GetUInt16(References, usize, *mut u16, usize): "all variables are Float64";
    fmi3GetInt32(References, usize, *mut i32, usize): "all variables are Float64";
    fmi3GetUInt32(References, usize, *mut u32, usize): "all variables are Float64";
    fmi3GetInt64(References, usize, *mut i64, usize): "all variables are Float64";
    fmi3GetUInt64(References, usize, *mut u64, usize): "all variables are Float64";
    fmi3GetBoolean(References, usize, *mut bool, usize): "all variables are Float64";
    fmi3GetString(References, usize, *mut *const c_char, usize): "all variables are Float64";
    fmi3GetBinary(References, usize, *mut usize, *mut *const u8, usize): "all variables are Float64";
    fmi3GetClock(References, usize, *mut bool): "there are no clocks";
    fmi3SetFloat32(References, usize, *const f32, usize): "all variables are Float64";
    fmi3SetInt8(References, usize, *const i8, usize): "all variables are Float64";
    fmi3SetUInt8(References, usize, *const u8, usize): "all variables are Float64";
    fmi3SetInt16(References, usize, *const i16, usize): "all variables are Float64";
    fmi3SetUInt16(References, usize, *const u16, usize): "all variables are Float64";
    fmi3SetInt32(References, usize, *const i32, usize): "all variables are Float64";
    fmi3SetUInt32(References, usize, *const u32, usize): "all variables are Float64";
    fmi3SetInt64(References, usize, *const i64, usize): "all variables are Float64";
    fmi3SetUInt64(References, usize, *const u64, usize): "all variables are Float64";
    fmi3SetBoolean(References, usize, *const bool, usize): "all variables are Float64";
    fmi3SetString(References, usize, *const *const c_char, usize): "all variables are Float64";
    fmi3SetBinary(References, usize, *const usize, *const *const u8, usize): "all variables are Float64";
    fmi3SetClock(References, usize, *const bool): "there are no clocks";
    fmi3GetNumberOfVariableDependencies(u32, *mut usize): "dependencies are those of the description";
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut i32, usize):
        "dependencies are those of the description";
    fmi3GetDirectionalDerivative(References, usize, References, usize, *const f64, usize, *mut f64, usize):
        "a model with hysteresis has no derivatives";
    fmi3GetAdjointDerivative(References, usize, References, usize, *const f64, usize, *mut f64, usize):
        "a model with hysteresis has no derivatives";
    fmi3GetOutputDerivatives(References, usize, *const i32, *mut f64, usize):
        "a model with hysteresis has no derivatives";
    fmi3EnterConfigurationMode(): "there are no structural parameters";
    fmi3ExitConfigurationMode(): "there are no structural parameters";
    fmi3EnterEventMode(): "there are no events";
    fmi3EnterStepMode(): "there are no events";
    fmi3EvaluateDiscreteStates(): "there are no events";
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64):
        "there are no events";
    fmi3GetIntervalDecimal(References, usize, *mut f64, *mut i32): "there are no clocks";
    fmi3GetIntervalFraction(References, usize, *mut u64, *mut u64, *mut i32): "there are no clocks";
    fmi3GetShiftDecimal(References, usize, *mut f64): "there are no clocks";
    fmi3GetShiftFraction(References, usize, *mut u64, *mut u64): "there are no clocks";
    fmi3SetIntervalDecimal(References, usize, *const f64): "there are no clocks";
    fmi3SetIntervalFraction(References, usize, *const u64, *const u64): "there are no clocks";
    fmi3SetShiftDecimal(References, usize, *const f64): "there are no clocks";
    fmi3SetShiftFraction(References, usize, *const u64, *const u64): "there are no clocks";
    fmi3EnterContinuousTimeMode(): "the unit is for co-simulation";
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool): "the unit is for co-simulation";
    fmi3SetTime(f64): "the unit is for co-simulation";
    fmi3SetContinuousStates(*const f64, usize): "the unit is for co-simulation";
    fmi3GetContinuousStateDerivatives(*mut f64, usize): "the unit is for co-simulation";
    fmi3GetEventIndicators(*mut f64, usize): "the unit is for co-simulation";
    fmi3GetContinuousStates(*mut f64, usize): "the unit is for co-simulation";
    fmi3GetNominalsOfContinuousStates(*mut f64, usize): "the unit is for co-simulation";
    fmi3GetNumberOfEventIndicators(*mut usize): "the unit is for co-simulation";
    fmi3GetNumberOfContinuousStates(*mut usize): "the unit is for co-simulation";
    fmi3ActivateModelPartition(u32, f64): "the unit is for co-simulation";
}

/// Ways to make an instance that a unit for co-simulation does not have.
macro_rules! not_made {
    ($($name:ident($($argument:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments, reason = "the standard's")]
        extern "C" fn $name(
            _name: *const c_char,
            _token: *const c_char,
            _resources: *const c_char,
            _is_visible: bool,
            _logs: bool,
            environment: *const c_void,
            log: LogMessage,
            $(_: $argument),*
        ) -> *mut c_void {
            say(environment, log, Status::Error, "the unit is for co-simulation");
            null_mut()
        }
    )*};
}

not_made! {
    fmi3InstantiateModelExchange();
    fmi3InstantiateScheduledExecution(*const c_void, *const c_void, *const c_void);
}
