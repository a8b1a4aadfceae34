//! The line to a board, opened again whenever it breaks.
//!
//! A thread of its own reads, so nothing that arrives waits for what is being done with it.

use super::port::{Ends, Port};
use crate::failure::Failure;
use messages::board::MavMessage;
use messages::error::MessageReadError;
use messages::{MavHeader, MavlinkReader, MavlinkVersion, SigningData, write_v2_msg_signed};
use std::io::{ErrorKind, Read, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pause before a line that broke is tried again.
const RETRY: Duration = Duration::from_millis(200);
/// A board talks 50 times a second; after this long without a word the line is taken for dead.
const SILENCE: Duration = Duration::from_secs(10);

/// What comes over a line.
pub enum News {
    /// It is open.
    Up,
    /// It broke; why.
    Down(String),
    /// A message with a valid checksum.
    Message(Box<MavMessage>),
}

type Writer = Arc<Mutex<Option<Box<dyn Write + Send>>>>;

/// A line that is kept open.
pub struct Link {
    news: Receiver<News>,
    writer: Writer,
    sequence: u8,
    signing: Option<SigningData>,
}

impl Link {
    /// Opens it; the first time it must work.
    pub fn open(port: Port, baud: u32, signing: Option<SigningData>) -> Result<Self, Failure> {
        let ends = port.open(baud).map_err(|error| {
            let advice = "name a serial device that exists and that you may use, or tcp:HOST:PORT of what listens there";
            Failure::new(format!("{port}: cannot be opened: {error}"), advice)
        })?;
        let (sender, news) = channel();
        let writer = Writer::default();
        let shared = Arc::clone(&writer);
        std::thread::spawn(move || keep_open(&port, baud, ends, &sender, &shared));
        Ok(Self { news, writer, sequence: 0, signing })
    }

    /// The next piece of news, if one comes in time.
    pub fn hear(&self, patience: Duration) -> Option<News> {
        self.news.recv_timeout(patience).ok()
    }

    /// Sends one message. Where the line is down it is lost, as on any radio: who wants an answer asks again.
    pub fn send(&mut self, message: &MavMessage) {
        self.sequence = self.sequence.wrapping_add(1);
        let header = MavHeader { system_id: 255, component_id: 190, sequence: self.sequence };
        if let Some(writer) = lock(&self.writer).as_mut() {
            // a line that breaks here is noticed by the reader
            let _ = write_v2_msg_signed(writer, header, message, self.signing.as_ref());
        }
    }
}

fn lock(writer: &Writer) -> MutexGuard<'_, Option<Box<dyn Write + Send>>> {
    writer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads until nobody listens any more.
fn keep_open(port: &Port, baud: u32, mut ends: Ends, news: &Sender<News>, shared: &Writer) {
    loop {
        let (reader, writer) = ends;
        *lock(shared) = Some(writer);
        if news.send(News::Up).is_err() {
            return;
        }
        let Some(why) = listen(reader, news) else { return };
        *lock(shared) = None;
        if news.send(News::Down(why)).is_err() {
            return;
        }
        ends = loop {
            std::thread::sleep(RETRY);
            if let Ok(ends) = port.open(baud) {
                break ends;
            }
        };
    }
}

/// Hands on messages until the line breaks, and says why; none when nobody listens.
fn listen(reader: Box<dyn Read + Send>, news: &Sender<News>) -> Option<String> {
    let mut reader = MavlinkReader::new(reader);
    let mut heard = Instant::now();
    loop {
        match reader.read_message(MavlinkVersion::V2) {
            Ok((_, message)) => {
                heard = Instant::now();
                news.send(News::Message(Box::new(message))).ok()?;
            }
            // bytes that make no message are passed over
            Err(MessageReadError::Parse(_)) => {}
            Err(MessageReadError::Io(error)) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {
                    if heard.elapsed() > SILENCE {
                        return Some(format!("nothing heard for {} s", SILENCE.as_secs()));
                    }
                }
                ErrorKind::UnexpectedEof => return Some("the other end closed it".to_owned()),
                _ => return Some(error.to_string()),
            },
        }
    }
}
