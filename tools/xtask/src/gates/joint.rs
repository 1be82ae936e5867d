//! The tick of two channels, in the image `emulated_joint`: counted while it starts a joint and
//! tracks, and compared with the same code on the host, which has to answer the same, bit for bit.
//!
//! The joint is what the board wants it to be while it starts, so that it starts; afterwards it is
//! at the other end of its range, and what is asked for goes from end to end, so that the feedback
//! and all limits work hard. The stiffness steps too.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use board_models::joint::joint_parameters;
use firmware::joint::ANGLE;
use firmware::joint::lock_step::LockStepJoint;
use firmware::scaling::{COMMAND, PRESSURE};
use model_core::joint::{JointControl, JointTarget};
use wire::joint::{
    JOINT_VERSION, JointBoardState, JointConfiguration, JointRequest, JointResponse, JointTickReply,
    JointTickRequest,
};
use wire::{FRAME_BYTES, Protection, Receiver};

use super::bounds::Figure;
use super::counted::{self, Cost};
use super::elf::Image;

/// The interrupt of the tick.
const TICK: &str = "TIM2";
/// The controller in it.
const STEP: &str = "firmware::joint::joint_step";
/// Ticks of tracking, and how many of them go to one end.
const TRACKED: u32 = 2_000;
const ONE_WAY: u32 = 100;
/// Fastest turn in a tick. Unit: rad.
const FASTEST_RAD: f32 = 0.05;
/// A start is over long before.
const LONGEST_START: u32 = 20_000;

/// Instructions of the dearest tick, and of the controller in it.
///
/// # Errors
/// The image does not start the joint, or answers otherwise than the same code on the host.
pub fn figures(image: &Image, plugin: &Path) -> Result<Vec<Figure>> {
    let functions = [image.function(TICK)?, image.function(STEP)?];
    let costs = counted::run(image, plugin, &functions, drive)?;
    let name = ["whole tick", "controller"].map(|what| format!("{what} of the image emulated_joint"));
    let figure = |(name, Cost { calls, most }): (String, Cost)| Figure {
        name: format!("{name}, most instructions"),
        value: most,
        remark: format!("in {calls} ticks; two channels, as many stops as a board takes"),
    };
    Ok(name.into_iter().zip(costs).map(figure).collect())
}

fn drive(link: &UnixStream) -> Result<()> {
    let mut receiver = Receiver::new();
    receive(link, &mut receiver).context("its greeting")?;
    let mut host = LockStepJoint::new(Protection::SIMULATED);
    let mut demand = |request: &JointRequest| -> Result<JointResponse> {
        let mut buffer = [0; FRAME_BYTES];
        let frame = wire::encode(request, &mut buffer)?;
        let mut board = link;
        board.write_all(frame)?;
        let (answer, expected) = (receive(link, &mut receiver)?, host.answer(request));
        ensure!(answer == expected, "the board answers {answer:?}, the host {expected:?}");
        Ok(answer)
    };
    let control = joint_parameters();
    let joint = JointControl::try_new(&control)?;
    let (soft, stiff) = joint.joint().stiffness_range(0.0);
    let at = |share: f32| soft + share * (stiff - soft);
    let angles = control.joint.angles;
    demand(&JointRequest::Configure(JointConfiguration { version: JOINT_VERSION, control }))?;
    demand(&JointRequest::Arm)?;
    demand(&JointRequest::Start(at(0.5)))?;
    let mut tick = |target: JointTarget<f32>, angle: f32, last: [u16; 2]| -> Result<JointTickReply> {
        let request = JointTickRequest {
            target: Some(target),
            pressure_codes: last.map(|code| PRESSURE.code(COMMAND.value(code))),
            angle_code: ANGLE.code(angle),
        };
        match demand(&JointRequest::Tick(request))? {
            JointResponse::Tick(reply) if reply.fault.is_none() => Ok(reply),
            other => bail!("{other:?}"),
        }
    };
    let still = JointTarget { angle: 0.0, stiffness: at(0.5), load: 0.0 };
    let mut last = tick(still, 0.0, [0; 2])?;
    for _ in 0..LONGEST_START {
        if last.state == JointBoardState::Tracking {
            break;
        }
        last = tick(still, last.due_rad, last.dac_codes)?;
    }
    ensure!(last.state == JointBoardState::Tracking, "the joint does not start: {last:?}");
    let mut angle = last.due_rad;
    for number in 0..TRACKED {
        let is_up = (number / ONE_WAY).is_multiple_of(2);
        let (asked, other) = if is_up { (angles.1, angles.0) } else { (angles.0, angles.1) };
        // As fast as an angle may be without being taken for a spike.
        angle += (other - angle).clamp(-FASTEST_RAD, FASTEST_RAD);
        let stiffness = at(if is_up { 0.9 } else { 0.1 });
        last = tick(JointTarget { angle: asked, stiffness, load: 1.0 }, angle, last.dac_codes)?;
    }
    Ok(())
}

fn receive(mut link: &UnixStream, receiver: &mut Receiver) -> Result<JointResponse> {
    let mut byte = [0];
    loop {
        link.read_exact(&mut byte).context("no answer")?;
        if let Some(response) = receiver.push(byte[0]) {
            return Ok(response?);
        }
    }
}
