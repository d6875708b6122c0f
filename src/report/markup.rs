//! Text inside HTML and SVG.

/// Text with the reserved characters of HTML and SVG written as references.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
