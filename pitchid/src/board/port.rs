//! Where a board is: a serial device or a TCP address.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::Duration;

/// Longest wait for a byte before the reader looks around.
const READ: Duration = Duration::from_millis(100);
const CONNECT: Duration = Duration::from_secs(3);

/// Both ends of an open line.
pub type Ends = (Box<dyn Read + Send>, Box<dyn Write + Send>);

/// What the user named.
#[derive(Clone, Debug, PartialEq)]
pub enum Port {
    /// A device, and the baud rate is given apart.
    Serial(String),
    /// HOST:PORT.
    Tcp(String),
}

impl FromStr for Port {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_prefix("tcp:") {
            Some(address)
                if address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok()) =>
            {
                Ok(Self::Tcp(address.to_owned()))
            }
            Some(_) => Err("write tcp:HOST:PORT, for example tcp:127.0.0.1:5760".to_owned()),
            None => Ok(Self::Serial(text.to_owned())),
        }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(device) => f.write_str(device),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
        }
    }
}

impl Port {
    /// Opens it. Reads end after 100 ms without a byte.
    pub fn open(&self, baud: u32) -> io::Result<Ends> {
        match self {
            Self::Serial(device) => {
                let reader = serialport::new(device, baud).timeout(READ).open()?;
                let writer = reader.try_clone()?;
                Ok((Box::new(reader), Box::new(writer)))
            }
            Self::Tcp(address) => {
                let mut tried = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
                for place in address.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&place, CONNECT) {
                        Ok(stream) => return ends(stream),
                        Err(error) => tried = error,
                    }
                }
                Err(tried)
            }
        }
    }
}

fn ends(stream: TcpStream) -> io::Result<Ends> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(READ))?;
    Ok((Box::new(stream.try_clone()?), Box::new(stream)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_devices_are_told_apart() {
        assert_eq!("tcp:10.0.0.2:5760".parse(), Ok(Port::Tcp("10.0.0.2:5760".into())));
        assert_eq!("/dev/ttyUSB0".parse(), Ok(Port::Serial("/dev/ttyUSB0".into())));
        assert_eq!("COM3".parse(), Ok(Port::Serial("COM3".into())));
        for wrong in ["tcp:", "tcp:host", "tcp:host:port", "tcp:host:70000"] {
            assert!(wrong.parse::<Port>().unwrap_err().contains("tcp:HOST:PORT"), "{wrong}");
        }
    }
}
