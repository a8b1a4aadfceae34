//! An effect as an argument: `id` or `id:param=value,param=value`.

use host_sim::Setting;
use std::str::FromStr;

/// An effect as it is asked for.
#[derive(Clone, Debug)]
pub struct EffectSpec {
    /// Its id in the catalogue.
    pub id: String,
    parameters: Vec<(String, f64)>,
}

impl FromStr for EffectSpec {
    type Err = String;

    /// Parses `id` or `id:param=value,param=value`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (id, rest) = text.split_once(':').map_or((text, None), |(id, rest)| (id, Some(rest)));
        let parameter = |part: &str| -> Result<(String, f64), String> {
            let (name, value) = part.split_once('=').ok_or(format!("{part:?}: write PARAM=VALUE"))?;
            let number: f64 = value.trim().parse().map_err(|_| format!("{value:?} is no number"))?;
            Ok((name.trim().to_owned(), number))
        };
        let parameters = rest.map(|r| r.split(',').map(parameter).collect::<Result<_, _>>()).transpose()?;
        Ok(Self { id: id.trim().to_owned(), parameters: parameters.unwrap_or_default() })
    }
}

impl EffectSpec {
    /// The effect as the simulator conceals it; without parameters at a usual size.
    pub fn setting(&self) -> Result<Setting, host_sim::Error> {
        if self.parameters.is_empty() {
            return Setting::usual(&self.id, false);
        }
        let named: Vec<(&str, f64)> = self.parameters.iter().map(|(name, v)| (name.as_str(), *v)).collect();
        Setting::new(&self.id, &named)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_are_parsed_with_and_without_parameters() {
        let spec: EffectSpec = "inflow_lag:g=0.4, T_lambda=0.1".parse().unwrap();
        assert_eq!(spec.id, "inflow_lag");
        assert_eq!(spec.parameters, [("g".to_owned(), 0.4), ("T_lambda".to_owned(), 0.1)]);
        assert!("servo_lag".parse::<EffectSpec>().unwrap().parameters.is_empty());
        assert!("servo_lag:T".parse::<EffectSpec>().unwrap_err().contains("PARAM=VALUE"));
        assert!("servo_lag:T=x".parse::<EffectSpec>().unwrap_err().contains("no number"));
    }

    #[test]
    fn every_effect_flies_at_its_usual_size() {
        for entry in host_sim::effects::every() {
            assert!(entry.id.parse::<EffectSpec>().unwrap().setting().is_ok());
        }
    }
}
