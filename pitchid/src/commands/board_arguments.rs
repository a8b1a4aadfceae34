//! The arguments that name a board, shared by `record` and `fly`.

use crate::board::{Key, Port, Station};
use crate::failure::Failure;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub struct Line {
    /// Where the board is: a serial device, or tcp:HOST:PORT
    port: Port,

    /// Baud rate of a serial device
    #[arg(long, value_name = "BAUD", default_value_t = 230_400)]
    baud: u32,

    /// Sign what is sent, with the key in this file (64 hexadecimal digits)
    #[arg(long, value_name = "KEY")]
    key: Option<PathBuf>,
}

impl Line {
    /// Opens it.
    pub fn open(&self) -> Result<Station, Failure> {
        let key = self.key.as_deref().map(Key::read).transpose()?;
        Station::open(&self.port, self.baud, key.as_ref())
    }
}
