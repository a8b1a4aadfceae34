//! TDK InvenSense ICM-42688-P, data sheet DS-000347.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use super::{Axes, ImuFault, READ, configure, write};

/// WHO_AM_I, section 14.47.
pub(super) const IDENTITY: u8 = 0x47;

const DEVICE_CONFIG: u8 = 0x11;
const SOFT_RESET: u8 = 0x01;
/// First of 12 bytes: acceleration x, y, z, rate x, y, z, big-endian.
const ACCEL_DATA_X1: u8 = 0x1F;
const PWR_MGMT0: u8 = 0x4E;

const SETTINGS: [(u8, u8); 4] = [
    // GYRO_CONFIG0: ±500 °/s, 1 kHz
    (0x4F, 0x46),
    // ACCEL_CONFIG0: ±8 g, 1 kHz
    (0x50, 0x26),
    // GYRO_ACCEL_CONFIG0: both low-pass at 1 kHz / 40 = 25 Hz
    (0x52, 0x77),
    // PWR_MGMT0: both in low-noise mode
    (PWR_MGMT0, 0x0F),
];

pub(super) fn set_up(spi: &mut impl SpiDevice, delay: &mut impl DelayNs) -> Result<(), ImuFault> {
    write(spi, DEVICE_CONFIG, SOFT_RESET)?;
    // section 14.1: 1 ms
    delay.delay_ms(2);
    configure(spi, &SETTINGS)?;
    // section 14.36: the gyro needs 45 ms to start
    delay.delay_ms(50);
    Ok(())
}

pub(super) fn burst(spi: &mut impl SpiDevice) -> Result<Axes, ImuFault> {
    let mut bytes = [0; 13];
    bytes[0] = ACCEL_DATA_X1 | READ;
    spi.transfer_in_place(&mut bytes).map_err(|_| ImuFault::Bus)?;
    let [_, a, b, c, d, e, f, g, h, i, j, k, l] = bytes;
    Ok([[a, b], [c, d], [e, f], [g, h], [i, j], [k, l]].map(i16::from_be_bytes))
}

#[cfg(test)]
mod tests {
    use super::super::bench::{asked, big_endian, kept, mock, wrote};
    use super::super::{Chip, Imu, ImuFault};
    use embedded_hal_mock::eh1::delay::NoopDelay;

    #[test]
    fn set_up_and_burst_are_the_data_sheets() {
        let mut spi = mock(&[
            asked(0x75, &[0x47]),
            wrote(0x11, 0x01),
            kept(0x4F, 0x46),
            kept(0x50, 0x26),
            kept(0x52, 0x77),
            kept(0x4E, 0x0F),
            asked(0x1F, &big_endian([4096, 0, 0, 1, -655, 2])),
        ]);
        let mut imu = Imu::new(spi.clone(), &mut NoopDelay::new()).unwrap();
        assert_eq!(imu.chip(), Chip::Icm42688);
        let motion = imu.read().unwrap();
        assert!((motion.force_m_s2[0] - 9.806_65).abs() < 1e-4);
        assert!((motion.q_rad_s - 10_f32.to_radians()).abs() < 1e-6);
        spi.done();
    }

    #[test]
    fn a_register_that_does_not_keep_its_value_is_named() {
        let mut spi =
            mock(&[asked(0x75, &[0x47]), wrote(0x11, 0x01), wrote(0x4F, 0x46), asked(0x4F, &[0x06])]);
        assert_eq!(Imu::new(spi.clone(), &mut NoopDelay::new()).err(), Some(ImuFault::Register(0x4F)));
        spi.done();
    }
}
