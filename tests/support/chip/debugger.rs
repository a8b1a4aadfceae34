//! The emulator's debugger port (GDB remote serial protocol): stops the chip, looks into it and disturbs it from outside, so
//! that the image under test is the one that flies.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use super::emulator::{accept, listen};

/// A debugger that waits for its emulator.
pub struct Waiting {
    listener: TcpListener,
    /// What the emulator must be started with.
    pub arguments: Vec<String>,
}

/// A debugger on a stopped or running chip.
pub struct Debugger {
    line: TcpStream,
}

impl Waiting {
    /// Opens the port.
    #[must_use]
    pub fn open() -> Self {
        let (listener, port) = listen();
        let socket = format!("socket,id=debugger,host=127.0.0.1,port={port},nodelay=on");
        let arguments = ["-chardev", &socket, "-gdb", "chardev:debugger"].map(str::to_owned).to_vec();
        Self { listener, arguments }
    }

    /// Takes the emulator's call; the chip stands still.
    #[must_use]
    pub fn attach(self) -> Debugger {
        let line = accept(&self.listener);
        line.set_read_timeout(Some(Duration::from_secs(30))).expect("a socket takes a timeout");
        let mut debugger = Debugger { line };
        debugger.halt();
        // peripherals are reached by their physical addresses only
        assert_eq!(debugger.ask("Qqemu.PhyMemMode:1"), "OK");
        debugger
    }
}

impl Debugger {
    /// Lets the chip run.
    pub fn go(&mut self) {
        self.send("c");
    }

    /// Lets it run, from `address` on; odd, as addresses of its instructions are.
    pub fn go_from(&mut self, address: u32) {
        self.send(&format!("c{address:x}"));
    }

    /// Stops it.
    pub fn halt(&mut self) {
        self.line.write_all(&[3]).expect("the debugger's line is open");
        self.stopped();
    }

    /// Waits until it stops by itself.
    pub fn stopped(&mut self) {
        let why = self.receive();
        assert!(why.starts_with('T') || why.starts_with('S'), "the chip stops: {why}");
    }

    /// Stops when a word at `address` is written, before the write acts.
    pub fn watch(&mut self, address: u32) {
        assert_eq!(self.ask(&format!("Z2,{address:x},4")), "OK");
    }

    /// No longer.
    pub fn unwatch(&mut self, address: u32) {
        assert_eq!(self.ask(&format!("z2,{address:x},4")), "OK");
    }

    /// A word.
    pub fn read(&mut self, address: u32) -> u32 {
        let text = self.ask(&format!("m{address:x},4"));
        u32::from_str_radix(&text, 16).map(u32::swap_bytes).unwrap_or_else(|_| panic!("a word, not {text}"))
    }

    /// Writes a word.
    pub fn write(&mut self, address: u32, word: u32) {
        assert_eq!(self.ask(&format!("M{address:x},4:{:08x}", word.swap_bytes())), "OK");
        assert_eq!(self.read(address), word, "what was written to {address:#x} stays there");
    }

    fn ask(&mut self, question: &str) -> String {
        self.send(question);
        self.receive()
    }

    fn send(&mut self, packet: &str) {
        let sum = packet.bytes().fold(0_u8, u8::wrapping_add);
        self.line.write_all(format!("${packet}#{sum:02x}").as_bytes()).expect("the debugger's line is open");
    }

    fn receive(&mut self) -> String {
        let mut packet = Vec::new();
        let mut byte = || {
            let mut byte = [0];
            self.line.read_exact(&mut byte).expect("the emulator answers its debugger");
            byte[0]
        };
        // acknowledgements come between packets
        while byte() != b'$' {}
        loop {
            match byte() {
                b'#' => break,
                other => packet.push(other),
            }
        }
        let _checksum = [byte(), byte()];
        self.line.write_all(b"+").expect("the debugger's line is open");
        String::from_utf8_lossy(&packet).into_owned()
    }
}
