//! QEMU's `netduinoplus2`, an STM32F405, with the link on a socket.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const QEMU: &str = "qemu-system-arm";
const CONNECT: Duration = Duration::from_secs(20);

const RAM_START: usize = 0x2000_0000;
const RAM_BYTES: usize = 0x2_0000;
const PAINT: [u8; 4] = [0xCC; 4];

/// A running emulator; dropped, it ends.
pub struct Emulator {
    process: Child,
    link: TcpStream,
    monitor: TcpStream,
}

/// Names of the variables that hold the images: the one that flies, and the one whose control cycle fails on demand.
pub const FLIGHT: &str = "PITCHID_FLIGHT_IMAGE";
/// See [`FLIGHT`].
pub const FAULTS: &str = "PITCHID_FAULTS_IMAGE";

/// The image named by the variable, or why there is none.
fn image(variable: &str) -> Result<PathBuf, String> {
    let found =
        std::env::var_os(variable).ok_or("no image; `cargo xtask chip-test` builds one and runs this")?;
    let probe = Command::new(QEMU).arg("--version").stdout(Stdio::null()).status();
    probe.map_err(|error| format!("{QEMU} cannot be run ({error}); install it (Debian: qemu-system-arm)"))?;
    Ok(PathBuf::from(found))
}

impl Emulator {
    /// Boots the image; without one, says why on standard output and returns none.
    pub fn boot() -> Option<Self> {
        Self::boot_with(FLIGHT, &[])
    }

    /// Boots the image named by `variable`, the emulator under further `arguments`.
    pub fn boot_with(variable: &str, arguments: &[String]) -> Option<Self> {
        match image(variable) {
            Ok(image) => Some(Self::start(&image, arguments)),
            Err(why) => {
                println!("skipped: {why}");
                None
            }
        }
    }

    fn start(image: &std::path::Path, arguments: &[String]) -> Self {
        let (listener, port) = listen();
        let (monitors, monitor_port) = listen();
        let process = Command::new(QEMU)
            .args(["-machine", "netduinoplus2", "-nographic", "-monitor"])
            .arg(format!("tcp:127.0.0.1:{monitor_port}"))
            .args(["-serial", "null", "-serial"])
            .arg(format!("tcp:127.0.0.1:{port},nodelay=on"))
            .arg("-kernel")
            .arg(image)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .expect("the emulator starts");
        let (monitor, link) = (accept(&monitors), accept(&listener));
        link.set_nodelay(true).expect("a socket takes the option");
        link.set_read_timeout(Some(Duration::from_millis(200))).expect("a socket takes a timeout");
        Self { process, link, monitor }
    }

    /// Puts bytes on the wire.
    pub fn send(&mut self, bytes: &[u8]) {
        self.link.write_all(bytes).expect("the emulator listens");
    }

    /// Presses the reset button.
    pub fn reset(&mut self) {
        writeln!(self.monitor, "system_reset").expect("the monitor listens");
    }

    /// Bytes of stack that were ever used: start-up paints it, and the paint is gone where it was.
    pub fn stack_bytes(&mut self) -> usize {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let dump = folder.path().join("ram");
        writeln!(self.monitor, "pmemsave {RAM_START:#x} {RAM_BYTES:#x} \"{}\"", dump.display())
            .expect("the monitor listens");
        let begin = Instant::now();
        loop {
            let ram = std::fs::read(&dump).unwrap_or_default();
            if ram.len() == RAM_BYTES {
                let words = ram.chunks_exact(4).rev();
                // a few words of a frame may hold the paint's pattern; a kilobyte of it was never touched
                let (mut used, mut painted) = (0, 0);
                for (place, word) in words.enumerate() {
                    painted = if word == PAINT { painted + 1 } else { 0 };
                    if painted == 256 {
                        used = 4 * (place + 1 - painted);
                        break;
                    }
                }
                return used;
            }
            assert!(begin.elapsed() < CONNECT, "the monitor saves the memory");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// What has come since, waiting a little if there is nothing.
    pub fn receive(&mut self) -> Vec<u8> {
        let mut bytes = [0; 4096];
        let count = self.link.read(&mut bytes).unwrap_or(0);
        bytes[..count].to_vec()
    }
}

pub(super) fn listen() -> (TcpListener, u16) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a local port is free");
    let port = listener.local_addr().expect("a bound socket has an address").port();
    (listener, port)
}

pub(super) fn accept(listener: &TcpListener) -> TcpStream {
    listener.set_nonblocking(true).expect("a socket takes the option");
    let begin = Instant::now();
    loop {
        if let Ok((link, _)) = listener.accept() {
            link.set_nonblocking(false).expect("a socket takes the option");
            return link;
        }
        assert!(begin.elapsed() < CONNECT, "{QEMU} did not connect within {} s", CONNECT.as_secs());
        std::thread::sleep(Duration::from_millis(10));
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // it may have ended already
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
