//! What the board keeps when the power goes: parameters and signing key in one record, the monitor's model in another.

use embedded_storage::nor_flash::NorFlash;
use estimator_core::monitor::NUMBERS;

use crate::link::signing::Key;
use crate::parameters::PARAMETERS;
use crate::store::{NotKept, SECTOR, Store, slot_of};

/// Bytes of flash that the board keeps its records in: two sectors for the model, then two for the settings.
pub const LENGTH: u32 = 4 * SECTOR;
const MODELS: u32 = 0;
const SETTINGS: u32 = 2 * SECTOR;
/// Parameters of another table do not count, nor models of other numbers.
const MARK: u32 = 0x5049_0100 + PARAMETERS.len() as u32;
const MODEL_MARK: u32 = 0x504D_0000 + NUMBERS as u32;

const VALUES: usize = 4 * PARAMETERS.len();
/// One byte for whether there is a key, the key, its timestamp.
const SIGNING: usize = 1 + 32 + 8;
const SLOT: usize = slot_of(VALUES + SIGNING);
const MODEL_SLOT: usize = slot_of(4 * NUMBERS);

/// Parameters and key.
#[derive(Clone, Copy)]
pub struct Settings {
    /// Value of each parameter, in the order of the table.
    pub values: [f32; PARAMETERS.len()],
    /// Key and latest timestamp.
    pub signing: Option<(Key, u64)>,
}

impl Settings {
    fn payload(&self) -> [u8; VALUES + SIGNING] {
        let mut payload = [0; VALUES + SIGNING];
        let values = self.values.iter().flat_map(|value| value.to_le_bytes());
        let signing = self
            .signing
            .iter()
            .flat_map(|(Key(key), timestamp)| [1].into_iter().chain(*key).chain(timestamp.to_le_bytes()));
        payload.iter_mut().zip(values.chain(signing)).for_each(|(to, byte)| *to = byte);
        payload
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let mut values = [0.0; PARAMETERS.len()];
        let (words, _) = payload.get(..VALUES)?.as_chunks();
        values.iter_mut().zip(words).for_each(|(value, word)| *value = f32::from_le_bytes(*word));
        let (has_key, rest) = payload.get(VALUES..)?.split_first()?;
        let (key, rest) = rest.split_first_chunk()?;
        let timestamp = rest.first_chunk().copied().map(u64::from_le_bytes)?;
        Some(Self { values, signing: (*has_key == 1).then_some((Key(*key), timestamp)) })
    }
}

/// The records, and where the next ones go.
pub struct Memory<F> {
    flash: F,
    settings: Store<SLOT>,
    models: Store<MODEL_SLOT>,
}

impl<F: NorFlash> Memory<F> {
    /// Finds what was kept, and makes room for more. Before the watchdog runs.
    pub fn open(mut flash: F) -> Self {
        let settings = Store::open(&mut flash, SETTINGS, MARK);
        let models = Store::open(&mut flash, MODELS, MODEL_MARK);
        Self { flash, settings, models }
    }

    /// The settings that were kept last.
    pub fn settings(&mut self) -> Option<Settings> {
        Settings::read(self.settings.newest(&mut self.flash)?.payload())
    }

    /// Puts the numbers of the model that was kept last into `numbers`; false where there is none.
    pub fn recall_model(&mut self, numbers: &mut [f32; NUMBERS]) -> bool {
        let Some(record) = self.models.newest(&mut self.flash) else { return false };
        let (words, _) = record.payload().as_chunks();
        numbers.iter_mut().zip(words).for_each(|(number, word)| *number = f32::from_le_bytes(*word));
        true
    }

    /// Keeps the settings.
    ///
    /// # Errors
    /// A flash that is full or failing.
    pub fn keep(&mut self, settings: &Settings) -> Result<(), NotKept> {
        self.settings.save(&mut self.flash, &settings.payload())
    }

    /// Keeps the numbers of a model.
    ///
    /// # Errors
    /// A flash that is full or failing.
    pub fn keep_model(&mut self, numbers: &[f32; NUMBERS]) -> Result<(), NotKept> {
        self.models.save(&mut self.flash, &number_bytes(numbers))
    }
}

/// The numbers of a model, four bytes each, the lowest first.
#[must_use]
pub fn number_bytes(numbers: &[f32; NUMBERS]) -> [u8; 4 * NUMBERS] {
    let mut bytes = [0; 4 * NUMBERS];
    let (words, _) = bytes.as_chunks_mut();
    words.iter_mut().zip(numbers).for_each(|(word, number)| *word = number.to_le_bytes());
    bytes
}
