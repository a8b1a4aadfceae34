//! The set-up: this program, the terminal, devices, the vehicle's file, where answers would go.

use super::{Examined, Step};
use crate::failure::Failure;
use crate::output::width;
use crate::vehicle::{NAME, Vehicle};
use std::io::IsTerminal;
use std::path::Path;

/// Looks at it.
pub fn examined(vehicle: &Result<Option<Vehicle>, Failure>) -> Examined {
    let mut steps = vec![
        Step::well(format!(
            "pitchid {} on {} ({})",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH
        )),
        terminal(),
    ];
    steps.extend(devices());
    steps.push(match vehicle {
        Ok(Some(vehicle)) => Step::well(format!("{}: {}", vehicle.path.display(), vehicle.told())),
        Ok(None) => Step::well(format!("no {NAME} here or above: every option stands on the command line")),
        Err(failure) => Step::of(failure),
    });
    steps.extend(vehicle.iter().flatten().filter_map(model));
    steps.push(folder());
    Examined { name: None, steps, next: Some("pitchid demo, or pitchid doctor FILE".into()) }
}

fn terminal() -> Step {
    let named = |is_terminal| if is_terminal { "a terminal" } else { "a file or a pipe" };
    let (out, err) = (std::io::stdout().is_terminal(), std::io::stderr().is_terminal());
    let progress = if err { "shown" } else { "not shown" };
    Step::well(format!(
        "answers go to {}, {} columns wide; messages to {}, progress is {progress} there",
        named(out),
        width(),
        named(err)
    ))
}

/// Serial devices, by their rights alone: opening one can reset the board behind it.
fn devices() -> Vec<Step> {
    let ports = match serialport::available_ports() {
        Ok(ports) => ports,
        Err(error) => {
            let remedy = "name the device to pitchid fly or record all the same, or use tcp:HOST:PORT";
            return vec![Step::doubtful(format!("serial devices cannot be listed: {error}"), remedy)];
        }
    };
    if ports.is_empty() {
        return vec![Step::well("no serial device: only pitchid fly and record need one, or tcp:HOST:PORT")];
    }
    let step = |port: &serialport::SerialPortInfo| {
        let name = &port.port_name;
        match may_use(Path::new(name)) {
            true => Step::well(format!("{name} may be opened")),
            false => Step::doubtful(
                format!("{name} may not be opened"),
                "add yourself to the group of the device (often dialout), and log in again",
            ),
        }
    };
    ports.iter().map(step).collect()
}

#[cfg(unix)]
fn may_use(path: &Path) -> bool {
    use rustix::fs::{Access, access};
    access(path, Access::READ_OK | Access::WRITE_OK).is_ok()
}

#[cfg(not(unix))]
fn may_use(path: &Path) -> bool {
    // a port that another program holds is told when it is opened
    !path.as_os_str().is_empty()
}

/// The model that the vehicle's file names, where it cannot be read.
fn model(vehicle: &Vehicle) -> Option<Step> {
    let path = vehicle.model.as_deref()?;
    Some(match crate::commands::reading::model_at(path, None) {
        Ok(_) => Step::well(format!("{}: a model that can be read", path.display())),
        Err(failure) => Step::of(&failure),
    })
}

/// Whether answers can be written here.
fn folder() -> Step {
    let here = std::env::current_dir().map_or_else(|_| ".".to_owned(), |here| here.display().to_string());
    match tempfile_in(Path::new(".")) {
        Ok(()) => Step::well(format!("answers can be written in {here}")),
        Err(error) => Step::wrong(
            format!("{here} cannot be written: {error}"),
            "go to a folder of your own, or name files there",
        ),
    }
}

/// Makes a file and removes it again.
fn tempfile_in(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!(".pitchid-doctor-{}", std::process::id()));
    std::fs::File::create_new(&path)?;
    std::fs::remove_file(path)
}
