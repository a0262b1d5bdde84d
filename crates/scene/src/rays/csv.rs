//! Parses rays in CSV: a line of column names, then one ray per line.

/// The column names, in the order of a raw ray.
pub(super) const COLUMNS: [&str; 8] = ["ox", "oy", "oz", "t_min", "dx", "dy", "dz", "t_max"];

/// For each column of the file, the index of its name in [`COLUMNS`].
pub(super) struct Columns(Vec<usize>);

impl Columns {
    /// Returns whether a line consists of known column names.
    pub(super) fn are_named_by(line: &str) -> bool {
        names(line).all(|name| COLUMNS.contains(&&*name))
    }

    /// Parses the first line, which names the columns, or returns an error message.
    pub(super) fn of(line: &str) -> Result<Self, String> {
        let mut columns = Vec::new();
        for name in names(line) {
            let known = COLUMNS.iter().position(|&column| column == name);
            let known = known.ok_or_else(|| {
                let name = quote(&name);
                format!("{name} is not a column of rays; the columns are {}", COLUMNS.join(","))
            })?;
            if columns.contains(&known) {
                return Err(format!("two columns are named {name}"));
            }
            columns.push(known);
        }
        let optional = |name: &str| name == "t_min" || name == "t_max";
        match (0..8).find(|&i| !columns.contains(&i) && !optional(COLUMNS[i])) {
            Some(missing) => Err(format!("no column is named {}", COLUMNS[missing])),
            None => Ok(Self(columns)),
        }
    }

    /// Parses a line and returns its numbers in the order of a raw ray, or an error message.
    pub(super) fn numbers(&self, line: &str) -> Result<[f64; 8], String> {
        let mut numbers = [0.0; 8];
        numbers[7] = f64::INFINITY;
        let (mut columns, mut found) = (self.0.iter(), 0);
        for cell in line.split(',') {
            found += 1;
            let Some(&column) = columns.next() else { continue };
            numbers[column] = number(cell)
                .map_err(|why| format!("{}: {} {why}", COLUMNS[column], quote(cell)))?;
        }
        let named = self.0.len();
        if found == named {
            Ok(numbers)
        } else {
            Err(format!("{found} cells, but the first line names {named} columns"))
        }
    }
}

/// Iterates over the names in a line, in lower case.
fn names(line: &str) -> impl Iterator<Item = String> {
    line.split(',').map(|name| unquoted(name).to_ascii_lowercase())
}

/// Parses a cell as a number.
fn number(cell: &str) -> Result<f64, &'static str> {
    let cell = unquoted(cell);
    let number: f64 = cell.parse().map_err(|_| "is not a number")?;
    // Infinity is accepted only if it is written as a word.
    if !number.is_finite() && cell.contains(|c: char| c.is_ascii_digit()) {
        return Err("is beyond the range of f64");
    }
    Ok(number)
}

/// Returns a cell without surrounding blanks and quotes.
fn unquoted(cell: &str) -> &str {
    cell.trim().trim_matches('"').trim()
}

/// Quotes a cell for an error message, and shortens it if it is long.
pub(super) fn quote(cell: &str) -> String {
    let cell = unquoted(cell);
    let short: String = cell.chars().take(32).collect();
    format!("{short:?}{}", if short.len() < cell.len() { "..." } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_once_and_infinity_must_be_meant() {
        assert_eq!(number(" 1e-3 "), Ok(1e-3));
        assert_eq!(number("\"-inf\""), Ok(f64::NEG_INFINITY));
        assert!(number("NaN").unwrap().is_nan());
        assert_eq!(number("0.1").map(f64::to_bits), Ok(0.1f64.to_bits()));
        assert_eq!(number("1e39"), Ok(1e39));
        assert!(number("1e309").unwrap_err().ends_with("f64"));
        assert!(number("").is_err() && number("1;2").is_err());
    }

    #[test]
    fn a_line_of_names_has_known_ones_alone() {
        assert!(Columns::are_named_by(" \"OX\",oy\r\n"));
        assert!(!Columns::are_named_by("ox,oy,oz,dx,dy,dz,colour"));
        assert!(!Columns::are_named_by("") && !Columns::are_named_by("hello"));
    }
}
