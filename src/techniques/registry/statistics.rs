//! Statistics of techniques: named values of a light or of a frame.

/// Named values, in the order in which the names were first set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics(Vec<(&'static str, Statistic)>);

/// A value of a statistic.
#[derive(Clone, Debug, PartialEq)]
pub enum Statistic {
    /// There is no value, for example because a light has no map.
    Nothing,
    /// The value is true or false.
    Flag(bool),
    /// The value is a whole number.
    Count(u64),
    /// The value is any number.
    Number(f64),
    /// The value is a word or a sentence.
    Text(String),
    /// The value is a list of values.
    List(Vec<Statistic>),
    /// The value is a group of values that have names of their own.
    Group(Statistics),
}

impl Statistics {
    /// Sets the value of a name. An earlier value of the name is replaced.
    pub fn set(&mut self, name: &'static str, value: impl Into<Statistic>) {
        let value = value.into();
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = value,
            None => self.0.push((name, value)),
        }
    }

    /// Returns the value of a name, if it was set.
    pub fn get(&self, name: &str) -> Option<&Statistic> {
        self.iter()
            .find_map(|(known, value)| (known == name).then_some(value))
    }

    /// Yields the names with their values.
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
