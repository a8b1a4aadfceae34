//! A board on a TCP port: the image's own ground link and core, flying the simulated aircraft as fast as it is let.

use estimator_core::constants::MAX_TAPS;
use estimator_core::{Command, Config, Cycle, CycleState, Input, Sample, Telemetry, Vehicle};
use firmware::link::decoder::Decoder;
use firmware::link::ground::extra_crc;
use firmware::link::{Action, Ground};
use firmware::watch::Watch;
use host_sim::aircraft::Aircraft;
use host_sim::pilot::ManualReference;
use host_sim::seeds::{Stream, generator};
use host_sim::vehicle::SimulatedVehicle;
use host_sim::{Plant, Scenario};
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Pause between two cycles.
const PACE: Duration = Duration::from_micros(200);

/// What happens to the line.
#[derive(Clone, Default)]
pub struct Script {
    /// Cycles at which the line breaks, and for how many cycles it stays so.
    pub breaks: Vec<(u32, u32)>,
    /// Cycle at which a test begins by itself.
    pub starts: Option<u32>,
    /// Cycle at which the board resets.
    pub resets: Option<u32>,
    /// Bytes that make no frame, sent every ten cycles.
    pub noise: Vec<u8>,
    /// Frames that the board is given before anyone connects.
    pub first: Vec<u8>,
}

/// What the board has put on the line, or what it would have.
#[derive(Default)]
pub struct Sent {
    /// Cycles that were written to an open line.
    pub cycles: Vec<Telemetry>,
    /// The estimate at the end.
    pub taps: Vec<f32>,
}

/// A board that listens.
pub struct Board {
    pub port: String,
    pub sent: Arc<Mutex<Sent>>,
}

impl Board {
    pub fn boot(script: Script) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = format!("tcp:{}", listener.local_addr().unwrap());
        let sent = Arc::new(Mutex::new(Sent::default()));
        let log = Arc::clone(&sent);
        std::thread::spawn(move || Running::new(listener, script, log).run());
        Self { port, sent }
    }
}

struct Running {
    listener: TcpListener,
    line: Option<TcpStream>,
    script: Script,
    sent: Arc<Mutex<Sent>>,
    ground: Ground,
    decoder: Decoder,
    test: Cycle<MAX_TAPS>,
    state: CycleState<MAX_TAPS>,
    vehicle: SimulatedVehicle,
    flown: u32,
    command: Command,
    armed: bool,
    watch: Watch,
}

fn vehicle() -> SimulatedVehicle {
    let scenario = Scenario::campaign(4, 0.015, 3).unwrap();
    let reference = ManualReference::drawn(25.0, &mut generator(3, Stream::Reference));
    let aircraft = Aircraft::new(Plant::nominal(), &[], None, 3);
    SimulatedVehicle::new(aircraft, scenario.noise, generator(3, Stream::Sensors), reference)
}

impl Running {
    fn new(listener: TcpListener, script: Script, sent: Arc<Mutex<Sent>>) -> Self {
        let mut ground = Ground::new(Config::default()).unwrap();
        ground.sensors = true;
        let test = *ground.test();
        Self {
            listener,
            line: None,
            script,
            sent,
            ground,
            decoder: Decoder::new(extra_crc),
            state: test.initial_state(),
            test,
            vehicle: vehicle(),
            flown: 0,
            command: Command::None,
            armed: false,
            watch: Watch::default(),
        }
    }

    fn run(mut self) {
        let first = std::mem::take(&mut self.script.first);
        self.hear(&first);
        self.line = Some(self.listener.accept().unwrap().0);
        let mut clock = 0;
        for cycle in 1_u32.. {
            clock += 1;
            self.listen();
            if self.script.starts == Some(cycle) {
                self.act(Action::Start);
            }
            if self.script.resets == Some(cycle) {
                let script = std::mem::take(&mut self.script);
                let line = self.line.take();
                self = Self { line, ..Self::new(self.listener, script, self.sent) };
                clock = 1;
            }
            if let Some(&(_, dark)) = self.script.breaks.iter().find(|(at, _)| *at == cycle) {
                self.close();
                (0..dark).for_each(|further| self.fly(clock + further));
                clock += dark;
                self.line = Some(self.listener.accept().unwrap().0);
            }
            self.fly(clock);
            if cycle.is_multiple_of(10) {
                let noise = self.script.noise.clone();
                self.line.iter_mut().for_each(|line| line.write_all(&noise).unwrap_or_default());
            }
            std::thread::sleep(PACE);
        }
    }

    /// Ends the line without losing a byte that was written.
    fn close(&mut self) {
        let Some(mut line) = self.line.take() else { return };
        line.shutdown(Shutdown::Write).unwrap();
        line.set_nonblocking(false).unwrap();
        line.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
        while matches!(line.read(&mut [0; 512]), Ok(1..)) {}
    }

    fn listen(&mut self) {
        let Some(line) = &mut self.line else { return };
        line.set_nonblocking(true).unwrap();
        let mut bytes = [0; 1024];
        let count = match line.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
            Err(_) => return self.line = None,
        };
        line.set_nonblocking(false).unwrap();
        self.hear(&bytes[..count]);
    }

    fn hear(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let (mut actions, mut answers) = (Vec::new(), Vec::new());
            let Self { decoder, ground, .. } = self;
            decoder.push(byte, |frame| {
                actions.extend(ground.receive(&frame, &mut |answer| answers.extend_from_slice(answer)));
            });
            self.write(&answers);
            actions.into_iter().for_each(|action| self.act(action));
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Arm => {
                self.ground.begin(&mut self.watch);
                self.armed = true;
            }
            Action::Disarm => (self.armed, self.command) = (false, Command::Abort),
            Action::Abort => self.command = Command::Abort,
            Action::Start => {
                self.test = *self.ground.test();
                self.state = self.test.initial_state();
                (self.vehicle, self.flown, self.command) = (vehicle(), 0, Command::Start);
            }
            Action::Hil(_) | Action::Tick(_) | Action::Reference(_) | Action::Model => {}
        }
    }

    fn write(&mut self, bytes: &[u8]) -> bool {
        self.line.as_mut().is_some_and(|line| line.write_all(bytes).is_ok())
    }

    fn fly(&mut self, tick: u32) {
        let sensed = self.vehicle.sense(self.flown);
        self.flown += 1;
        let now_us = u64::from(tick) * 20_000;
        let sample = sensed.sample.map(|sample| Sample { time_us: now_us, ..sample });
        let input = Input { tick, now_us, sample, command: std::mem::take(&mut self.command), ..sensed };
        let telemetry = self.test.step(&mut self.state, &input);
        self.vehicle.actuate(telemetry.u_rad);
        self.vehicle.emit(&telemetry);
        let (mut bytes, taps) = (Vec::new(), *self.state.taps());
        let monitor = if self.armed { self.watch.step(&telemetry) } else { None };
        self.ground
            .report(&telemetry, monitor.as_ref(), || taps, &mut |frame| bytes.extend_from_slice(frame));
        // held while writing, so that nobody sees a cycle recorded before it is counted as sent
        let sent = Arc::clone(&self.sent);
        let mut sent = sent.lock().unwrap();
        if self.write(&bytes) {
            sent.cycles.push(telemetry);
        }
        if telemetry.phase.runs() {
            sent.taps = taps.to_vec();
        }
    }
}
