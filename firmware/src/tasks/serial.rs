//! The serial line: frames out, commands in.

use crate::faults::Task;
use crate::shared::Shared;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Timer};
use embedded_io_async::{Read, Write};
use wire::{Command, Decoder, ToRobot, encode};

/// Without frames to send, the task still shows that it lives.
const IDLE: Duration = Duration::from_millis(100);

/// Sends what the other tasks have to say.
pub async fn telemetry(line: &mut impl Write, shared: &Shared) -> ! {
    loop {
        if let Either::First(frame) = select(shared.frames.receive(), Timer::after(IDLE)).await {
            let sent = match encode(&frame) {
                Ok(bytes) => line.write_all(&bytes).await.is_ok(),
                Err(_) => false,
            };
            if !sent {
                shared.faults.count(|faults| &mut faults.frames_dropped);
            }
        }
        shared.reports.report(Task::Telemetry);
    }
}

/// Takes commands from the line and hands them on.
pub async fn commands(line: &mut impl Read, shared: &Shared) -> ! {
    let mut decoder = Decoder::of_robot();
    let mut bytes = [0; 32];
    loop {
        // A broken line is as if damaged: what follows is found again by its frame.
        let count = line.read(&mut bytes).await.unwrap_or_else(|_| {
            shared.faults.count(|faults| &mut faults.bytes_lost);
            0
        });
        if count == 0 {
            Timer::after(IDLE).await;
        }
        for byte in bytes.iter().take(count) {
            match decoder.push(*byte) {
                None => {}
                Some(Ok(ToRobot::Command(command))) => take(command, shared),
                Some(Ok(ToRobot::MapRequest(request))) => shared.map_request.signal(request),
                Some(_) => shared.faults.count(|faults| &mut faults.bytes_lost),
            }
        }
    }
}

fn take(command: Command, shared: &Shared) {
    if command == Command::ResetMap {
        shared.reset_map.signal(());
    } else {
        shared.push_command(command);
    }
}
