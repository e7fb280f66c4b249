//! On which way of the pressure a reading lies: branches and cycles.
//!
//! The pressure turns where it has come back from an extreme by more than a threshold: what is smaller is noise. Up to the extreme, and
//! with it, is one branch, what follows is the other. A cycle is a way up and the way down behind it, so the low end of a way down
//! belongs to it: the zero behind a cycle is what that cycle leaves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which way the pressure went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Branch {
    /// Up, and all that lies before the first way down.
    Loading,
    /// Down.
    Unloading,
}

impl Branch {
    /// Its name on pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Loading => "loading",
            Self::Unloading => "unloading",
        }
    }
}

/// The branch and the cycle, from 1, of each of a series of pressures.
pub fn ways(pressures: &[f64], threshold: f64) -> Vec<(Branch, usize)> {
    let mut turns: Vec<(usize, Branch)> = Vec::new();
    let mut branch = Branch::Loading;
    // The extreme of the present branch.
    let mut extreme = 0;
    for (i, p) in pressures.iter().enumerate() {
        let top = pressures[extreme];
        let (further, back) = match branch {
            Branch::Loading => (*p > top, *p < top - threshold),
            Branch::Unloading => (*p < top, *p > top + threshold),
        };
        if further {
            extreme = i;
        } else if back {
            turns.push((extreme, branch));
            branch = if branch == Branch::Loading { Branch::Unloading } else { Branch::Loading };
            extreme = i;
        }
    }
    let mut ways = Vec::with_capacity(pressures.len());
    let mut turns = turns.into_iter().peekable();
    let (mut branch, mut cycle) = (Branch::Loading, 1);
    for i in 0..pressures.len() {
        ways.push((branch, cycle));
        while let Some((_, ending)) = turns.next_if(|(at, _)| *at == i) {
            match ending {
                Branch::Loading => branch = Branch::Unloading,
                Branch::Unloading => (branch, cycle) = (Branch::Loading, cycle + 1),
            }
        }
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;
    use Branch::{Loading as L, Unloading as U};

    #[test]
    fn cycles_are_ways_up_with_the_ways_down_behind_them() {
        let found = ways(&[0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 1.0, 3.0, 1.0, 0.0, 0.0], 0.1);
        let expected = [(L, 1), (L, 1), (L, 1), (L, 1), (U, 1), (U, 1), (U, 1), (L, 2), (L, 2), (U, 2), (U, 2), (U, 2)];
        assert_eq!(found, expected);
    }

    #[test]
    fn noise_turns_nothing_and_a_log_may_begin_at_the_top() {
        assert!(ways(&[0.0, 1.0, 0.95, 2.0, 1.92, 3.0], 0.1).iter().all(|way| *way == (L, 1)));
        assert_eq!(ways(&[3.0, 2.0, 1.0], 0.1), [(L, 1), (U, 1), (U, 1)]);
        assert_eq!(ways(&[], 0.1), []);
        // A slow way back is one, however small its steps.
        assert_eq!(ways(&[1.0, 0.95, 0.9, 0.85, 0.8], 0.1)[4], (U, 1));
    }
}
