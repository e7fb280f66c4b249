//! A drawing as SVG on a page: colours are classes, so that they follow the page; what can be read off is there for pointer and keyboard
//! without a script.

use std::fmt::Write as _;

use super::{Anchor, CROSS, Element, FORMS, MARK_STROKE, Px, Readout, Scene, Shape, TEXT_PX, Tint, Words};
use crate::format::visible;

/// Height of a line of a readout, in its font.
const LINE_EM: f64 = 1.4;

/// Mean width of a letter of a readout, in its font: rather too wide than too narrow.
const LETTER_EM: f64 = 0.56;

/// The drawing as an `svg` element; `label` says what it shows to those who cannot see it.
pub fn svg(scene: &Scene, label: &str) -> String {
    let mut out = String::new();
    let (width, height) = (number(scene.size.0), number(scene.size.1));
    // A group, not an image: an image would hide what can be read off from a reader's keyboard.
    push(
        &mut out,
        format_args!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"group\" aria-label=\"{}\"><g aria-hidden=\"true\">",
            escaped(label)
        ),
    );
    for element in &scene.elements {
        draw(&mut out, element);
    }
    out.push_str("</g>");
    for readout in &scene.readouts {
        read(&mut out, readout, scene);
    }
    out.push_str("</svg>");
    out
}

/// A small `svg` element for a legend.
pub fn swatch(elements: &[Element]) -> String {
    let mut out = "<svg viewBox=\"0 0 30 18\" class=\"key\" aria-hidden=\"true\">".to_owned();
    for element in elements {
        draw(&mut out, element);
    }
    out.push_str("</svg>");
    out
}

fn push(out: &mut String, text: std::fmt::Arguments) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(text);
}

/// Text in an attribute or between tags.
fn escaped(text: &str) -> String {
    quick_xml::escape::escape(visible(text)).into_owned()
}

/// A length to a tenth of a px, which no eye can tell from more.
fn number(px: f64) -> String {
    let tenths = (10.0 * px).round();
    if tenths % 10.0 == 0.0 { format!("{:.0}", tenths / 10.0 + 0.0) } else { format!("{:.1}", tenths / 10.0) }
}

fn class(tint: Tint) -> String {
    match tint {
        Tint::Ink => "c-ink".to_owned(),
        Tint::Muted => "c-muted".to_owned(),
        Tint::Grid => "c-grid".to_owned(),
        Tint::Paper => "c-paper".to_owned(),
        Tint::Bound => "c-bound".to_owned(),
        Tint::BoundEdge => "c-bound-edge".to_owned(),
        Tint::Flag => "c-flag".to_owned(),
        Tint::FlagEdge => "c-flag-edge".to_owned(),
        Tint::Solid => "c-solid".to_owned(),
        Tint::Form(i) => format!("c-{}", i % FORMS),
    }
}

/// A path through places.
fn path(points: &[Px]) -> String {
    let mut out = String::with_capacity(10 * points.len());
    let mut last = (String::new(), String::new());
    for (i, point) in points.iter().enumerate() {
        let at = (number(point.0), number(point.1));
        // Places that fall on one another are one, but a path has two.
        if at == last && i > 1 {
            continue;
        }
        out.push_str(match i {
            0 => "M",
            1 => "L",
            _ => " ",
        });
        push(&mut out, format_args!("{} {}", at.0, at.1));
        last = at;
    }
    out
}

fn draw(out: &mut String, element: &Element) {
    match element {
        Element::Rect { at, size, tint } => push(
            out,
            format_args!(
                "<path class=\"f {}\" d=\"M{} {}h{}v{}h-{}z\"/>",
                class(*tint),
                number(at.0),
                number(at.1),
                number(size.0),
                number(size.1),
                number(size.0)
            ),
        ),
        Element::Area { corners, tint } => {
            push(out, format_args!("<path class=\"f {}\" d=\"{}z\"/>", class(*tint), path(corners)));
        }
        Element::Line { points, tint, width, is_dashed } => {
            let dashes = if *is_dashed { " stroke-dasharray=\"7 4.5\"" } else { "" };
            push(
                out,
                format_args!(
                    "<path class=\"l {}\" stroke-width=\"{}\"{dashes} d=\"{}\"/>",
                    class(*tint),
                    number(*width),
                    path(points)
                ),
            );
        }
        Element::Segments { ends, tint, width } => {
            let all: String = ends.iter().map(|ends| path(ends)).collect();
            push(
                out,
                format_args!("<path class=\"l {}\" stroke-width=\"{}\" d=\"{all}\"/>", class(*tint), number(*width)),
            );
        }
        Element::Marks { at, tint, shape } => marks(out, at, *tint, *shape),
        Element::Words(words) => write_words(out, words),
    }
}

fn marks(out: &mut String, at: &[Px], tint: Tint, shape: Shape) {
    let class = class(tint);
    let all = |one: &dyn Fn(&Px) -> String| at.iter().map(one).collect::<String>();
    match shape {
        // A line of no length with round ends is a disc, in few bytes.
        Shape::Disc | Shape::Dot => {
            let d = all(&|p| format!("M{} {}h0", number(p.0), number(p.1)));
            let rim = if shape == Shape::Disc { 2.0 * (shape.radius() + 1.0) } else { 0.0 };
            if rim > 0.0 {
                push(out, format_args!("<path class=\"l c-paper\" stroke-width=\"{}\" d=\"{d}\"/>", number(rim)));
            }
            let width = number(2.0 * shape.radius());
            push(out, format_args!("<path class=\"l {class}\" stroke-width=\"{width}\" d=\"{d}\"/>"));
        }
        Shape::Ring => {
            let r = number(shape.radius());
            for p in at {
                push(
                    out,
                    format_args!(
                        "<circle class=\"ring {class}\" stroke-width=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{r}\"/>",
                        number(MARK_STROKE),
                        number(p.0),
                        number(p.1)
                    ),
                );
            }
        }
        Shape::Cross => {
            let twice = number(2.0 * CROSS);
            let d = all(&|p| {
                format!("M{} {}l{twice} {twice}m-{twice} 0l{twice} -{twice}", number(p.0 - CROSS), number(p.1 - CROSS))
            });
            push(out, format_args!("<path class=\"l c-paper\" stroke-width=\"4.4\" d=\"{d}\"/>"));
            push(out, format_args!("<path class=\"l {class}\" stroke-width=\"{}\" d=\"{d}\"/>", number(MARK_STROKE)));
        }
        Shape::Square | Shape::Triangle | Shape::Diamond => {
            let d = all(&|p| {
                let corners: Vec<Px> = shape.corners().iter().map(|c| (p.0 + c.0, p.1 + c.1)).collect();
                path(&corners) + "z"
            });
            push(out, format_args!("<path class=\"f rim {class}\" d=\"{d}\"/>"));
        }
    }
}

fn write_words(out: &mut String, words: &Words) {
    let anchor = match words.anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let ordinary = (words.size - TEXT_PX).abs() < 0.05;
    let size = if ordinary { String::new() } else { format!(" font-size=\"{}\"", number(words.size)) };
    let bold = if words.is_bold { " font-weight=\"600\"" } else { "" };
    let spare = if words.is_spare { " spare" } else { "" };
    push(
        out,
        format_args!(
            "<text class=\"f {}{spare}\" x=\"{}\" y=\"{}\" dy=\".35em\"{anchor}{size}{bold}>{}</text>",
            class(words.tint),
            number(words.at.0),
            number(words.at.1),
            escaped(&words.text)
        ),
    );
}

fn read(out: &mut String, readout: &Readout, scene: &Scene) {
    let (at, (corner, size)) = (readout.at, readout.field);
    let label = escaped(&readout.lines.join("; "));
    push(
        out,
        format_args!(
            "<g class=\"ro\" tabindex=\"0\" role=\"img\" aria-label=\"{label}\"><path class=\"hit\" d=\"M{} {}h{}v{}h-{}z\"/>",
            number(corner.0),
            number(corner.1),
            number(size.0),
            number(size.1),
            number(size.0)
        ),
    );
    if readout.is_column {
        push(
            out,
            format_args!("<path class=\"guide\" d=\"M{} {}v{}\"/>", number(at.0), number(corner.1), number(size.1)),
        );
    } else {
        push(out, format_args!("<circle class=\"guide\" cx=\"{}\" cy=\"{}\" r=\"9\"/>", number(at.0), number(at.1)));
    }
    // In heights of its font, so that the box grows with the text where a page makes that larger.
    let letters = readout.lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let wide = LETTER_EM * letters as f64 + 1.4;
    let high = LINE_EM * readout.lines.len() as f64 + 0.7;
    let is_left = at.0 < 0.5 * scene.size.0;
    let top = if readout.is_column { corner.1 + 6.0 } else { at.1 };
    // Beside the place, and within the figure: above it where there is no room below.
    let up = if readout.is_column {
        0.0
    } else if at.1 > 0.5 * scene.size.1 {
        high + 0.4
    } else {
        -0.4
    };
    let left = if is_left { 0.9 } else { -wide - 0.9 };
    push(
        out,
        format_args!(
            "<g class=\"tip\" transform=\"translate({} {})\"><rect x=\"{left:.2}em\" y=\"{:.2}em\" width=\"{wide:.2}em\" height=\"{high:.2}em\" rx=\"4\"/><text y=\"{:.2}em\">",
            number(at.0),
            number(top),
            -up,
            -up - 0.05
        ),
    );
    for line in &readout.lines {
        push(out, format_args!("<tspan x=\"{:.2}em\" dy=\"{LINE_EM}em\">{}</tspan>", left + 0.7, escaped(line)));
    }
    out.push_str("</text></g></g>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_short_and_zero_has_no_sign() {
        assert_eq!(
            ["12", "12.3", "0", "-0.5"],
            [12.02, 12.26, -0.04, -0.45].map(number).each_ref().map(String::as_str)
        );
    }

    #[test]
    fn what_users_wrote_is_text_in_attributes_and_between_tags() {
        let mut scene = Scene::new((100.0, 50.0));
        scene.words((1.0, 2.0), "<b>\"&'\u{202e}\u{1b}", Anchor::Start, Tint::Ink);
        scene.readouts.push(Readout {
            at: (1.0, 1.0),
            field: ((0.0, 0.0), (10.0, 10.0)),
            is_column: true,
            lines: vec!["\"><script>".to_owned()],
        });
        let text = svg(&scene, "\" onload=\"x");
        assert!(!text.contains("<b>") && !text.contains("<script") && !text.contains("\" onload"), "{text}");
        assert!(!text.contains('\u{202e}') && !text.contains('\u{1b}'), "{text}");
        let mut reader = quick_xml::Reader::from_str(&text);
        while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
    }

    #[test]
    fn places_that_fall_on_one_another_are_one() {
        assert_eq!(path(&[(0.0, 0.0), (1.0, 1.0), (1.01, 1.01), (2.0, 2.0)]), "M0 0L1 1 2 2");
    }
}
