//! Columns that a program has in memory instead of in a file.

use super::assign::{ROW, Source, assign};
use super::columns::Role;
use super::table::{LARGEST_TIME, LARGEST_VALUE, Signal, Table};
use super::{Note, ReadOptions, Recording, missing, on_grid};
use crate::error::{Error, ErrorKind};

/// A column of a recording.
#[derive(Clone, Debug)]
pub enum Column {
    /// Numbers; NaN where nothing was measured.
    Numbers(Vec<f64>),
    /// Labels of sections: for each row an index into the names.
    Labels {
        /// The names.
        names: Vec<String>,
        /// The index of each row.
        rows: Vec<u32>,
    },
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Labels { rows, .. } => rows.len(),
        }
    }
}

/// Makes a recording of columns in memory; each has the name that it would have in a CSV file, and is treated as there.
///
/// # Errors
/// As [`super::parse`], with rows, counted from 1, instead of lines; columns of different lengths.
pub fn from_columns(
    name: &str,
    columns: Vec<(String, Column)>,
    options: &ReadOptions,
) -> Result<Recording, Error> {
    let mut notes = Vec::new();
    let found = table(columns, options, &mut notes).and_then(|mut table| {
        missing::leave_out(&mut table, options.input_hold, &mut notes)?;
        on_grid(name, table, options, notes)
    });
    found.map_err(|error| error.in_file(name))
}

fn table(
    mut columns: Vec<(String, Column)>,
    options: &ReadOptions,
    notes: &mut Vec<Note>,
) -> Result<Table, Error> {
    let rows = columns.first().map_or(0, |(_, column)| column.len());
    if let Some((name, column)) = columns.iter().find(|(_, column)| column.len() != rows) {
        let found = format!("{} values where the first column has {rows}", column.len());
        return Err(Error::new(ErrorKind::Value, found, "give each row one value").in_column(name.as_str()));
    }
    let header: Vec<String> = columns.iter().map(|(name, _)| name.clone()).collect();
    let sources = assign(&header, &options.columns, notes)?;
    if sources.iter().any(|source| source.places.contains(&header.len())) {
        columns.push((ROW.into(), Column::Numbers((0..rows).map(|row| row as f64).collect())));
    }
    let mut uses = vec![0; columns.len()];
    sources.iter().flat_map(|source| &source.places).for_each(|&place| uses[place] += 1);
    let mut table = Table::default();
    for source in sources {
        match source.role {
            Role::Section => (table.label_names, table.labels) = labels(&source, &mut columns)?,
            Role::Supervised => {
                table.supervised = flags(&source, &worked(&source, &mut columns, &mut uses)?)?;
            }
            Role::Unmeasured => {
                table.unmeasured = flags(&source, &worked(&source, &mut columns, &mut uses)?)?;
            }
            Role::Time => {
                table.t = worked(&source, &mut columns, &mut uses)?;
                checked(&source, &table.t, LARGEST_TIME)?;
                table.time = source;
            }
            _ => {
                let values = worked(&source, &mut columns, &mut uses)?;
                checked(&source, &values, LARGEST_VALUE)?;
                table.signals.push(Signal { source, values });
            }
        }
    }
    Ok(table)
}

/// What a source gives in each row, in SI units. A column that nothing else needs is not copied.
fn worked(source: &Source, columns: &mut [(String, Column)], uses: &mut [usize]) -> Result<Vec<f64>, Error> {
    let refuse = |name: &str| {
        let advice = "give numbers; labels belong in the column section";
        Error::new(ErrorKind::Value, "labels where numbers belong", advice).in_column(name)
    };
    if let [place] = source.places[..]
        && source.expression.as_column().is_some()
    {
        uses[place] -= 1;
        let (name, column) = &mut columns[place];
        let Column::Numbers(values) = column else { return Err(refuse(name)) };
        let mut values = if uses[place] == 0 { std::mem::take(values) } else { values.clone() };
        values.iter_mut().for_each(|value| *value *= source.factor);
        return Ok(values);
    }
    let numbers = source.places.iter().map(|&place| match &columns[place] {
        (_, Column::Numbers(values)) => Ok(values.as_slice()),
        (name, Column::Labels { .. }) => Err(refuse(name)),
    });
    let numbers = numbers.collect::<Result<Vec<&[f64]>, Error>>()?;
    let mut cells = vec![0.0; numbers.len()];
    let value = |row: usize| {
        cells.iter_mut().zip(&numbers).for_each(|(cell, values)| *cell = values[row]);
        let value = source.factor * source.expression.value(&cells);
        if value.is_finite() { value } else { f64::NAN }
    };
    let worked = (0..numbers.first().map_or(0, |values| values.len())).map(value).collect();
    source.places.iter().for_each(|&place| uses[place] -= 1);
    Ok(worked)
}

fn checked(source: &Source, values: &[f64], largest: f64) -> Result<(), Error> {
    let Some(row) = values.iter().position(|value| value.abs() > largest) else { return Ok(()) };
    let found = format!("found {} in row {}, beyond any measurement in this unit", values[row], row + 1);
    let advice = "look for a broken logger or a wrong unit; NaN says that nothing was measured";
    Err(Error::new(ErrorKind::Value, found, advice).in_column(source.name.as_str()))
}

fn labels(source: &Source, columns: &mut [(String, Column)]) -> Result<(Vec<String>, Vec<u32>), Error> {
    let column = source.places.first().map(|&place| &mut columns[place].1);
    let Some(Column::Labels { names, rows }) = column else {
        let advice = "give texts: I, II, III, IV, or - between sections";
        let error = Error::new(ErrorKind::Value, "numbers where labels belong", advice);
        return Err(error.in_column(source.name.as_str()));
    };
    let names = names.iter().map(|name| match name.trim() {
        "" => "-".to_owned(),
        name => name.to_owned(),
    });
    Ok((names.collect(), std::mem::take(rows)))
}

fn flags(source: &Source, values: &[f64]) -> Result<Vec<bool>, Error> {
    let mut before = false;
    let flag = |(row, &value): (usize, &f64)| {
        before = match value {
            1.0 => true,
            0.0 => false,
            _ if value.is_nan() => before,
            _ => {
                let advice = format!("{}, else 0", source.role.set_where());
                let error = Error::new(ErrorKind::Value, format!("found {value} in row {}", row + 1), advice);
                return Err(error.in_column(source.name.as_str()).expecting("0 or 1"));
            }
        };
        Ok(before)
    };
    values.iter().enumerate().map(flag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::parse;

    const ROWS: usize = 120;

    fn columns() -> Vec<(String, Column)> {
        let of = |f: fn(f64) -> f64| Column::Numbers((0..ROWS).map(|k| f(k as f64)).collect());
        let rows = (0..ROWS).map(|k| u32::from(k >= 60)).collect();
        vec![
            ("t_s".into(), of(|k| 0.02 * k)),
            ("u_rad".into(), of(|k| (0.7 * k).sin())),
            ("q_deg_s".into(), of(|k| if k == 30.0 { f64::NAN } else { (0.3 * k).cos() })),
            ("section".into(), Column::Labels { names: vec!["I".into(), "IV".into()], rows }),
            ("supervised".into(), of(|k| f64::from(u8::from(k > 100.0)))),
            ("other".into(), of(|k| k)),
        ]
    }

    #[test]
    fn columns_in_memory_are_read_as_those_of_a_file() {
        let mut text = "t_s,u_rad,q_deg_s,section,supervised,other\n".to_owned();
        for k in 0..ROWS {
            let cell = |(_, column): &(String, Column)| match column {
                Column::Numbers(values) if values[k].is_nan() => String::new(),
                Column::Numbers(values) => values[k].to_string(),
                Column::Labels { names, rows } => names[rows[k] as usize].clone(),
            };
            text += &(columns().iter().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        let options =
            ReadOptions { columns: vec!["theta_rad=other-2*u_rad".parse().unwrap()], ..Default::default() };
        let mut file = parse("x", text.as_bytes(), &options).unwrap();
        let mut memory = from_columns("x", columns(), &options).unwrap();
        let told = memory.notes.iter().any(|note| note.text.contains("(row 31)"));
        assert!(told, "{:?}", memory.notes);
        // a file has lines, columns have rows
        let places = |recording: &mut Recording| {
            recording.notes.retain(|note| !note.text.contains("31") && !note.text.contains("32"));
        };
        places(&mut file);
        places(&mut memory);
        assert_eq!(file, memory);
    }

    #[test]
    fn what_cannot_be_a_column_is_refused() {
        let with = |name: &str, column: Column| {
            let mut columns = columns();
            columns.retain(|(known, _)| known != name);
            columns.push((name.to_owned(), column));
            from_columns("x", columns, &ReadOptions::default()).unwrap_err().to_string()
        };
        assert!(with("u_rad", Column::Numbers(vec![0.0; 3])).contains("3 values"));
        assert!(with("u_rad", Column::Numbers(vec![f64::INFINITY; ROWS])).contains("row 1"));
        assert!(with("supervised", Column::Numbers(vec![2.0; ROWS])).contains("0 or 1"));
        assert!(with("section", Column::Numbers(vec![2.0; ROWS])).contains("labels belong"));
        let labels = Column::Labels { names: vec!["a".into()], rows: vec![0; ROWS] };
        assert!(with("u_rad", labels).contains("give numbers"));
    }
}
