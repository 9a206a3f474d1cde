//! What a technique counts.

/// Names and values in the order in which they were first set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics(Vec<(&'static str, Statistic)>);

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub enum Statistic {
    /// There is nothing to tell.
    Nothing,
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Count(u64),
    /// A number.
    Number(f64),
    /// A word or a sentence.
    Text(String),
    /// Several values.
    List(Vec<Statistic>),
    /// Values with names of their own.
    Group(Statistics),
}

impl Statistics {
    /// Sets a value, in place of an earlier one of this name.
    pub fn set(&mut self, name: &'static str, value: impl Into<Statistic>) {
        let value = value.into();
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = value,
            None => self.0.push((name, value)),
        }
    }

    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<&Statistic> {
        self.iter()
            .find_map(|(known, value)| (known == name).then_some(value))
    }

    /// Names and values.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Statistic)> {
        self.0.iter().map(|(name, value)| (*name, value))
    }
}

impl From<bool> for Statistic {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<u32> for Statistic {
    fn from(value: u32) -> Self {
        Self::Count(u64::from(value))
    }
}

impl From<u64> for Statistic {
    fn from(value: u64) -> Self {
        Self::Count(value)
    }
}

impl From<usize> for Statistic {
    fn from(value: usize) -> Self {
        Self::Count(value as u64)
    }
}

impl From<f64> for Statistic {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<String> for Statistic {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<Statistics> for Statistic {
    fn from(value: Statistics) -> Self {
        Self::Group(value)
    }
}

impl<T: Into<Self>> From<Option<T>> for Statistic {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, T::into)
    }
}

impl<T: Into<Self>> From<Vec<T>> for Statistic {
    fn from(values: Vec<T>) -> Self {
        Self::List(values.into_iter().map(T::into).collect())
    }
}
