//! Lenses of photographs, whose poses are used and whose distortion is not: rendered pictures have none.

/// Lens effects that a file states beyond a pinhole.
#[derive(Debug, Default)]
pub struct Distortion {
    coefficients: Vec<String>,
    is_fisheye: bool,
}

impl Distortion {
    /// Adds a coefficient that is not 0, such as `k1`.
    pub fn add(&mut self, coefficient: &str) {
        if !self.coefficients.iter().any(|known| known == coefficient) {
            self.coefficients.push(coefficient.to_owned());
        }
    }

    pub fn add_fisheye(&mut self) {
        self.is_fisheye = true;
    }

    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.coefficients.is_empty() {
            notes.push(format!(
                "the lens distortion of the photographs ({}) was left out: poses and focal lengths are used",
                self.coefficients.join(", ")
            ));
        }
        if self.is_fisheye {
            notes.push("the fisheye lens was replaced by a pinhole with the same focal length".into());
        }
        notes
    }
}
