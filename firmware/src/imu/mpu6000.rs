//! InvenSense MPU-6000, product specification PS-MPU-6000A and register map RM-MPU-6000A.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use super::{Axes, ImuFault, READ, configure, write};

/// WHO_AM_I, register 117.
pub(super) const IDENTITY: u8 = 0x68;

const SIGNAL_PATH_RESET: u8 = 0x68;
const PWR_MGMT_1: u8 = 0x6B;
const DEVICE_RESET: u8 = 0x80;
/// First of 14 bytes: acceleration x, y, z, temperature, rate x, y, z, big-endian.
const ACCEL_XOUT_H: u8 = 0x3B;

const SETTINGS: [(u8, u8); 6] = [
    // PWR_MGMT_1: awake, clock of the gyro's x axis
    (PWR_MGMT_1, 0x01),
    // USER_CTRL: SPI only
    (0x6A, 0x10),
    // SMPLRT_DIV: 1 kHz
    (0x19, 0x00),
    // CONFIG: low-pass 4, 21 Hz and 20 Hz
    (0x1A, 0x04),
    // GYRO_CONFIG: ±500 °/s
    (0x1B, 0x08),
    // ACCEL_CONFIG: ±8 g
    (0x1C, 0x10),
];

pub(super) fn set_up(spi: &mut impl SpiDevice, delay: &mut impl DelayNs) -> Result<(), ImuFault> {
    // register map, section 4.28: over SPI a reset is followed by that of the signal paths, 100 ms after each
    write(spi, PWR_MGMT_1, DEVICE_RESET)?;
    delay.delay_ms(100);
    write(spi, SIGNAL_PATH_RESET, 0x07)?;
    delay.delay_ms(100);
    configure(spi, &SETTINGS)?;
    // product specification, section 6.1: the gyro needs 30 ms to start
    delay.delay_ms(50);
    Ok(())
}

pub(super) fn burst(spi: &mut impl SpiDevice) -> Result<Axes, ImuFault> {
    let mut bytes = [0; 15];
    bytes[0] = ACCEL_XOUT_H | READ;
    spi.transfer_in_place(&mut bytes).map_err(|_| ImuFault::Bus)?;
    let [_, a, b, c, d, e, f, _, _, g, h, i, j, k, l] = bytes;
    Ok([[a, b], [c, d], [e, f], [g, h], [i, j], [k, l]].map(i16::from_be_bytes))
}

#[cfg(test)]
mod tests {
    use super::super::bench::{asked, kept, mock, wrote};
    use super::super::{Chip, Imu};
    use embedded_hal_mock::eh1::delay::NoopDelay;

    #[test]
    fn set_up_and_burst_are_the_data_sheets() {
        let burst = [0x10, 0x00, 0, 0, 0, 0, 0x12, 0x34, 0, 1, 0xFD, 0x71, 0, 2];
        let mut spi = mock(&[
            asked(0x75, &[0x68]),
            wrote(0x6B, 0x80),
            wrote(0x68, 0x07),
            kept(0x6B, 0x01),
            kept(0x6A, 0x10),
            kept(0x19, 0x00),
            kept(0x1A, 0x04),
            kept(0x1B, 0x08),
            kept(0x1C, 0x10),
            asked(0x3B, &burst),
        ]);
        let mut imu = Imu::new(spi.clone(), &mut NoopDelay::new()).unwrap();
        assert_eq!(imu.chip(), Chip::Mpu6000);
        let motion = imu.read().unwrap();
        assert!((motion.force_m_s2[0] - 9.806_65).abs() < 1e-4);
        assert!((motion.q_rad_s - 10_f32.to_radians()).abs() < 1e-6);
        spi.done();
    }
}
