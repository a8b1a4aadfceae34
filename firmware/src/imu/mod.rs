//! The inertial sensor: ICM-42688-P or MPU-6000 over SPI, whichever answers.
//!
//! Both are set to ±500 °/s and ±8 g, 1 kHz inside, low-pass near 20 Hz: the excitation goes to 10 rad/s, and what lies above
//! 25 Hz must not fold into the 50 Hz samples. Mounted with x forward, y left, z up; what is read is turned to the body's
//! axes (x forward, y right, z down).

mod icm42688;
mod mpu6000;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use crate::pitch_filter::Motion;

/// Bit of the address that asks for a read.
const READ: u8 = 0x80;
/// Register of the identity, in both chips.
const WHO_AM_I: u8 = 0x75;
/// 65.5 counts per °/s at ±500 °/s (both data sheets).
const RATE_RAD_S: f32 = core::f32::consts::PI / 180.0 / 65.5;
/// 4096 counts per g at ±8 g (both data sheets).
const FORCE_M_S2: f32 = 9.806_65 / 4096.0;
/// Counts from which an axis counts as saturated.
const SATURATED: u16 = 32_700;
/// Equal bursts in a row that count as stuck. Six axes of 16 bits with at least one count of noise each repeat once with
/// odds below 0.3⁶, four times in a row below 3e-13.
const STUCK: u8 = 5;

/// What is wrong with the sensor.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum ImuFault {
    /// The SPI transfer failed.
    Bus,
    /// Neither chip answers; the identity found.
    Identity(u8),
    /// A register did not keep what was written to it.
    Register(u8),
    /// The same burst again and again.
    Stuck,
    /// An axis at the end of its range.
    Saturated,
    /// A value that the chip gives when it has measured nothing.
    Invalid,
}

/// The chips.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Chip {
    /// TDK InvenSense ICM-42688-P.
    Icm42688,
    /// InvenSense MPU-6000.
    Mpu6000,
}

/// Six axes as read: specific force, then rate, chip's axes.
type Axes = [i16; 6];

/// A sensor that answered and was set up.
#[derive(Debug)]
pub struct Imu<Spi> {
    spi: Spi,
    chip: Chip,
    last: Axes,
    repeats: u8,
}

impl<Spi: SpiDevice> Imu<Spi> {
    /// Asks for the identity and sets the chip up.
    ///
    /// # Errors
    /// Nobody answers, or a register does not keep its value.
    pub fn new(mut spi: Spi, delay: &mut impl DelayNs) -> Result<Self, ImuFault> {
        let chip = match read(&mut spi, WHO_AM_I)? {
            icm42688::IDENTITY => Chip::Icm42688,
            mpu6000::IDENTITY => Chip::Mpu6000,
            other => return Err(ImuFault::Identity(other)),
        };
        match chip {
            Chip::Icm42688 => icm42688::set_up(&mut spi, delay)?,
            Chip::Mpu6000 => mpu6000::set_up(&mut spi, delay)?,
        }
        Ok(Self { spi, chip, last: [0; 6], repeats: 0 })
    }

    /// The chip that answered.
    #[must_use]
    pub const fn chip(&self) -> Chip {
        self.chip
    }

    /// One burst.
    ///
    /// # Errors
    /// What was read cannot be acted on.
    pub fn read(&mut self) -> Result<Motion, ImuFault> {
        let axes = match self.chip {
            Chip::Icm42688 => icm42688::burst(&mut self.spi)?,
            Chip::Mpu6000 => mpu6000::burst(&mut self.spi)?,
        };
        self.repeats = if axes == self.last { self.repeats.saturating_add(1) } else { 1 };
        self.last = axes;
        if axes.contains(&i16::MIN) {
            return Err(ImuFault::Invalid);
        }
        if axes.iter().any(|axis| axis.unsigned_abs() >= SATURATED) {
            return Err(ImuFault::Saturated);
        }
        if self.repeats >= STUCK {
            return Err(ImuFault::Stuck);
        }
        Ok(motion(&axes))
    }
}

fn motion(&[fx, fy, fz, _, gy, _]: &Axes) -> Motion {
    Motion {
        q_rad_s: -RATE_RAD_S * f32::from(gy),
        force_m_s2: [f32::from(fx), -f32::from(fy), -f32::from(fz)].map(|axis| FORCE_M_S2 * axis),
    }
}

fn read(spi: &mut impl SpiDevice, register: u8) -> Result<u8, ImuFault> {
    let mut bytes = [register | READ, 0];
    spi.transfer_in_place(&mut bytes).map_err(|_| ImuFault::Bus)?;
    Ok(bytes[1])
}

fn write(spi: &mut impl SpiDevice, register: u8, value: u8) -> Result<(), ImuFault> {
    spi.write(&[register, value]).map_err(|_| ImuFault::Bus)
}

/// Writes and reads back.
fn configure(spi: &mut impl SpiDevice, settings: &[(u8, u8)]) -> Result<(), ImuFault> {
    for &(register, value) in settings {
        write(spi, register, value)?;
        if read(spi, register)? != value {
            return Err(ImuFault::Register(register));
        }
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod bench {
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    pub fn wrote(register: u8, value: u8) -> Vec<Transaction<u8>> {
        framed(Transaction::write_vec(vec![register, value]))
    }

    pub fn asked(register: u8, answer: &[u8]) -> Vec<Transaction<u8>> {
        let mut sent = vec![register | 0x80];
        sent.resize(answer.len() + 1, 0);
        let mut received = vec![0xff];
        received.extend(answer);
        framed(Transaction::transfer_in_place(sent, received))
    }

    pub fn kept(register: u8, value: u8) -> Vec<Transaction<u8>> {
        [wrote(register, value), asked(register, &[value])].concat()
    }

    fn framed(transaction: Transaction<u8>) -> Vec<Transaction<u8>> {
        vec![Transaction::transaction_start(), transaction, Transaction::transaction_end()]
    }

    pub fn big_endian(axes: [i16; 6]) -> Vec<u8> {
        axes.iter().flat_map(|axis| axis.to_be_bytes()).collect()
    }

    pub fn mock(parts: &[Vec<Transaction<u8>>]) -> Mock<u8> {
        Mock::new(&parts.concat())
    }
}

#[cfg(test)]
mod tests {
    use super::bench::{asked, big_endian, mock};
    use super::*;

    fn faults(bursts: &[[i16; 6]]) -> Vec<Option<ImuFault>> {
        let parts: Vec<_> = bursts.iter().map(|&axes| asked(0x1F, &big_endian(axes))).collect();
        let mut spi = mock(&parts);
        let mut imu = Imu { spi: spi.clone(), chip: Chip::Icm42688, last: [0; 6], repeats: 0 };
        let found = bursts.iter().map(|_| imu.read().err()).collect();
        spi.done();
        found
    }

    #[test]
    fn level_and_at_rest_and_a_nose_up_rate() {
        // z up reads +1 g; nose up turns about −y of the chip
        let found = motion(&[0, 0, 4096, 0, -655, 0]);
        assert!((found.force_m_s2[2] + 9.806_65).abs() < 1e-4);
        assert!((found.q_rad_s - 10_f32.to_radians()).abs() < 1e-6);
    }

    #[test]
    fn the_fifth_equal_burst_is_a_stuck_sensor() {
        let found = faults(&[[1, 2, 4096, 3, 4, 5]; 6]);
        assert_eq!(found, [None, None, None, None, Some(ImuFault::Stuck), Some(ImuFault::Stuck)]);
    }

    #[test]
    fn the_ends_of_the_range_and_the_mark_of_no_data_are_refused() {
        let found =
            faults(&[[0, 0, 0, 0, 32_767, 0], [0, 0, 4096, 0, -32_700, 0], [0, 0, 4096, 0, i16::MIN, 0]]);
        assert_eq!(found, [ImuFault::Saturated, ImuFault::Saturated, ImuFault::Invalid].map(Some));
    }

    #[test]
    fn a_chip_that_does_not_answer_is_named() {
        let mut delay = embedded_hal_mock::eh1::delay::NoopDelay::new();
        for silence in [0x00, 0xff] {
            let mut spi = mock(&[asked(WHO_AM_I, &[silence])]);
            assert_eq!(Imu::new(spi.clone(), &mut delay).err(), Some(ImuFault::Identity(silence)));
            spi.done();
        }
    }
}
