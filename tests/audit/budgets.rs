//! The budgets file: a limit for every figure, and what is allowed for a reason.
//!
//! A figure fails above its limit. It also fails when it fell by more than a twentieth below what the file says was
//! measured last, so that what was won is not lost again unseen. A figure that has no budget fails, and so does a budget
//! that nothing measures. Code of another compiler is another figure: with a compiler that is not the file's, figures that
//! fell are noted and do not fail.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml_edit::DocumentMut;

use super::forbidden::{Check, Finding};
use super::report::Figure;

/// The budgets file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budgets {
    /// The compiler that made the measured figures.
    pub compiler: String,
    /// A budget for each figure, by its name.
    pub figures: BTreeMap<String, Budget>,
    /// Findings that are allowed.
    #[serde(default)]
    pub allowed: Vec<Allowance>,
    /// Indirect calls that cannot be avoided, and what they call.
    #[serde(default)]
    pub indirect: Vec<Indirect>,
}

/// What a figure may be.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// What was measured last.
    pub figure: u64,
    /// What is promised: no more than this.
    pub limit: u64,
    /// Unit of both.
    pub unit: String,
    /// Where the limit comes from.
    pub reason: String,
}

/// A finding that is allowed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Allowance {
    /// The image.
    pub image: String,
    /// The check whose findings are allowed.
    pub check: String,
    /// Only if this stands in the finding's symbol or in a link of its chain.
    pub through: String,
    /// Why.
    pub reason: String,
}

/// An indirect call that cannot be avoided.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Indirect {
    /// The image.
    pub image: String,
    /// The function that calls.
    pub function: String,
    /// All functions that it may call.
    pub calls: Vec<String>,
    /// Why it is there, and how one knows what it calls.
    pub reason: String,
}

/// How a figure stands to its budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// Within.
    Within,
    /// Above its limit.
    Over,
    /// Fallen by more than a twentieth, and the file not lowered.
    Fell,
    /// The same, but made by another compiler than the file's.
    FellElsewhere,
    /// Measured in another unit than the file's.
    OtherUnit,
    /// Nobody gave it a budget.
    Unbudgeted,
    /// A budget that nothing measures.
    Unmeasured,
}

impl Standing {
    /// Whether it fails.
    #[must_use]
    pub fn fails(self) -> bool {
        !matches!(self, Standing::Within | Standing::FellElsewhere)
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Standing::Within => "",
            Standing::Over => "over its limit",
            Standing::Fell => "fell by more than 5 %: lower the file with --accept",
            Standing::FellElsewhere => "fell, by another compiler",
            Standing::OtherUnit => "has another unit in the file",
            Standing::Unbudgeted => "has no budget: give it one in the file",
            Standing::Unmeasured => "is not measured any more: take it out of the file",
        }
    }
}

/// A figure beside its budget.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Judged {
    /// Its name.
    pub name: String,
    /// What was measured, if anything was.
    pub value: Option<u64>,
    /// Its budget, if it has one.
    pub budget: Option<Budget>,
    /// Unit of the figure.
    pub unit: String,
    /// How it stands.
    pub standing: Standing,
}

impl Budgets {
    /// Reads the file.
    ///
    /// # Errors
    /// The file cannot be read, or is not of the form that its head describes.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{} cannot be read: {error}", path.display()))?;
        Self::parse(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Reads the file's text.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn parse(text: &str) -> Result<Self, String> {
        let budgets: Budgets = toml_edit::de::from_str(text).map_err(|error| error.to_string())?;
        for (name, budget) in &budgets.figures {
            if budget.reason.trim().is_empty() {
                return Err(format!("`{name}` gives no reason for its limit"));
            }
            if budget.figure > budget.limit {
                return Err(format!(
                    "`{name}` says that {} was accepted above the limit {}",
                    budget.figure, budget.limit
                ));
            }
        }
        for allowance in &budgets.allowed {
            if !Check::ALL.iter().any(|check| check.name() == allowance.check) {
                let known: Vec<&str> = Check::ALL.iter().map(|check| check.name()).collect();
                return Err(format!("no check is called `{}`; there are {}", allowance.check, known.join(", ")));
            }
        }
        Ok(budgets)
    }

    /// Sets each figure beside its budget. `families` are the first words of the names that were measured: a budget of
    /// another family is left alone.
    #[must_use]
    pub fn judge(&self, figures: &[Figure], families: &[&str], compiler: &str) -> Vec<Judged> {
        let mut judged: Vec<Judged> = figures.iter().map(|figure| self.judge_one(figure, compiler)).collect();
        let measured: BTreeSet<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        let family = |name: &str| families.contains(&name.split('.').next().unwrap_or(name));
        for (name, budget) in self.figures.iter().filter(|(name, _)| !measured.contains(name.as_str()) && family(name))
        {
            let (standing, unit) = (Standing::Unmeasured, budget.unit.clone());
            judged.push(Judged { name: name.clone(), value: None, budget: Some(budget.clone()), unit, standing });
        }
        judged
    }

    fn judge_one(&self, figure: &Figure, compiler: &str) -> Judged {
        let budget = self.figures.get(&figure.name);
        let standing = match budget {
            None => Standing::Unbudgeted,
            Some(budget) if budget.unit != figure.unit => Standing::OtherUnit,
            Some(budget) if figure.value > budget.limit => Standing::Over,
            Some(budget) if figure.value * 100 < budget.figure * 95 && compiler == self.compiler => Standing::Fell,
            Some(budget) if figure.value * 100 < budget.figure * 95 => Standing::FellElsewhere,
            Some(_) => Standing::Within,
        };
        let (value, unit) = (Some(figure.value), figure.unit.to_owned());
        Judged { name: figure.name.clone(), value, budget: budget.cloned(), unit, standing }
    }

    /// Splits the findings of an image into those that are not allowed and the allowances that nothing needs.
    #[must_use]
    pub fn sift(&self, image: &str, findings: &[Finding]) -> (Vec<Finding>, Vec<&Allowance>) {
        let allows = |allowance: &Allowance, finding: &Finding| {
            let links = finding.chain.iter().chain([&finding.symbol]);
            allowance.image == image
                && allowance.check == finding.check.name()
                && links.into_iter().any(|link| link.contains(&allowance.through))
        };
        let refused = |finding: &&Finding| !self.allowed.iter().any(|allowance| allows(allowance, finding));
        let idle = |allowance: &&Allowance| {
            allowance.image == image && !findings.iter().any(|finding| allows(allowance, finding))
        };
        (findings.iter().filter(refused).cloned().collect(), self.allowed.iter().filter(idle).collect())
    }
}

/// The text of a budgets file with the measured figures in place of the last ones; everything else, comments included,
/// stays. Figures above their limit, without a budget or with another unit are not taken.
///
/// # Errors
/// The text is not a budgets file.
pub fn accepted(text: &str, judged: &[Judged], compiler: &str) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    document["compiler"] = changed(&document["compiler"], compiler.into());
    for figure in judged {
        let takes = matches!(figure.standing, Standing::Within | Standing::Fell | Standing::FellElsewhere);
        let Some(value) = figure.value.filter(|_| takes).and_then(|value| i64::try_from(value).ok()) else { continue };
        let item = &mut document["figures"][&figure.name]["figure"];
        *item = changed(item, value.into());
    }
    Ok(document.to_string())
}

/// A value in the place of another one, what stands around it kept.
fn changed(item: &toml_edit::Item, mut value: toml_edit::Value) -> toml_edit::Item {
    if let Some(old) = item.as_value() {
        *value.decor_mut() = old.decor().clone();
    }
    value.into()
}

#[cfg(test)]
mod tests;
