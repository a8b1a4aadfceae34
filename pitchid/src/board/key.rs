//! The secret that signs what is sent to a board with a key set.

use crate::failure::Failure;
use messages::{SigningConfig, SigningData};
use std::path::Path;

/// The file holds 64 hexadecimal digits.
pub struct Key([u8; 32]);

/// Link id of what this command sends; a ground station beside it uses another.
const LINK: u8 = 7;

impl Key {
    /// Reads it.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let file = path.display();
        let advice = "the file holds the 32 bytes of the key as 64 hexadecimal digits";
        let text = sysid::files::read_text(path, advice)?;
        Self::parse(text.trim()).ok_or_else(|| Failure::new(format!("{file}: this is no key"), advice))
    }

    fn parse(text: &str) -> Option<Self> {
        let digits: Vec<u8> = text.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect::<Option<_>>()?;
        let bytes: Vec<u8> =
            digits.chunks(2).map(|pair| pair.iter().fold(0, |byte, digit| byte << 4 | digit)).collect();
        (digits.len() == 64).then(|| bytes.try_into().ok().map(Self)).flatten()
    }

    /// Signs outgoing frames. What comes in is telemetry, taken from whoever is on the line.
    pub fn signing(&self) -> SigningData {
        SigningData::from_config(SigningConfig::new(self.0, LINK, true, true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_64_hexadecimal_digits() {
        let key = Key::parse(&"5a".repeat(32)).unwrap();
        assert_eq!(key.0, [0x5a; 32]);
        for wrong in ["", "5a", &"5a".repeat(33), &"5g".repeat(32), &"é".repeat(32)] {
            assert!(Key::parse(wrong).is_none(), "{wrong}");
        }
    }
}
