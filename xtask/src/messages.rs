//! The code of the messages from their definitions.

use crate::{Outcome, output};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The generator that goes with mavlink-core.
const GENERATOR: &str = "mavlink-bindgen";

/// Writes `messages/src/board.rs` from `messages/board.xml`.
pub fn write() -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../messages");
    let work = folder.join("../target/messages");
    let failed = |error: std::io::Error| error.to_string();
    let (definitions, code) = (work.join("definitions"), work.join("code"));
    fs::create_dir_all(&definitions).map_err(failed)?;
    fs::create_dir_all(&code).map_err(failed)?;
    fs::copy(folder.join("board.xml"), definitions.join("board.xml")).map_err(failed)?;
    output(Command::new(GENERATOR).args([&definitions, &code])).map_err(|error| {
        format!(
            "{error}\n`cargo install {GENERATOR} --version 0.21.0 --features cli,mav2-message-extensions`"
        )
    })?;
    fs::copy(code.join("board.rs"), folder.join("src/board.rs")).map_err(failed)?;
    Ok(())
}
