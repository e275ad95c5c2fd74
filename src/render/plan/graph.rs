//! The frame graph: derives the order of passes, their targets and clears from the resources that each step reads and writes.
//!
//! A resource is a named colour target. In: [`PassStep`]s in any order, and the resource that is the final image. Out: a [`Plan`], whose passes are ordered so
//! that each resource is finished before it is read. Steps that draw over the same resource become one pass, in the order in which they were declared, so
//! that samples and depth need not be stored between them. Always: each resource is created once, each resource that is read is created, every draw
//! contributes to the final image; a violation is a [`GraphError`]. The plan refers to passes by index, so that the renderers need not know resource names.

use super::passes::{ColourFormat, Pass, Plan, PlanDraw, TextureBinding, TextureSource};
use std::collections::BTreeMap;

/// A colour target that a step creates.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetDescriptor {
    pub resource: &'static str,
    pub width: u32,
    pub height: u32,
    pub format: ColourFormat,
    /// Samples per pixel, 1 or 4.
    pub samples: u8,
    /// Clear colour: red, green, blue, alpha, as the format stores them.
    pub clear: [f32; 4],
    /// Whether a depth buffer belongs to the target.
    pub has_depth: bool,
}

/// How a step writes its resource.
#[derive(Clone, Debug, PartialEq)]
pub enum Write {
    /// Creates a resource, filled with the clear colour.
    New(TargetDescriptor),
    /// Draws over the content of a resource.
    Over(&'static str),
}

/// A finished resource that a step's draws read as a texture, and its binding in bind group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Read {
    pub resource: &'static str,
    pub binding: u32,
}

/// A part of a pass: draws, with the resource that they write and the resources that they read.
#[derive(Clone, Debug)]
pub struct PassStep {
    pub name: &'static str,
    pub reads: Vec<Read>,
    pub writes: Write,
    pub draws: Vec<PlanDraw>,
}

/// Why steps do not form a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GraphError {
    #[error("steps `{first}` and `{second}` both create `{resource}`")]
    CreatedTwice { resource: &'static str, first: &'static str, second: &'static str },
    #[error("step `{step}` needs `{resource}`, which no step creates")]
    NotCreated { step: &'static str, resource: &'static str },
    #[error("step `{step}` draws into `{resource}`, on which the image does not depend")]
    Unconnected { step: &'static str, resource: &'static str },
    #[error("step `{step}` reads `{resource}`, which is not finished before it")]
    Circular { step: &'static str, resource: &'static str },
    #[error("no step creates the image `{0}`")]
    NoImage(&'static str),
}

impl PassStep {
    /// The resource that the step writes.
    pub(crate) fn resource(&self) -> &'static str {
        match &self.writes {
            Write::New(target) => target.resource,
            Write::Over(resource) => resource,
        }
    }
}

/// Topological order of the resources: each comes after those that its steps read. `writers`: the steps that write each resource.
fn topological_order(writers: &BTreeMap<&'static str, Vec<&PassStep>>, image: &'static str) -> Result<Vec<&'static str>, GraphError> {
    #[derive(Clone, Copy, PartialEq)]
    enum VisitState {
        InProgress,
        Done,
    }
    /// Depth-first: appends `resource` to `order` after all resources that its steps read.
    fn visit(
        resource: &'static str,
        writers: &BTreeMap<&'static str, Vec<&PassStep>>,
        states: &mut BTreeMap<&'static str, VisitState>,
        order: &mut Vec<&'static str>,
    ) -> Result<(), GraphError> {
        states.insert(resource, VisitState::InProgress);
        for step in &writers[resource] {
            for read in &step.reads {
                match states.get(read.resource) {
                    Some(VisitState::Done) => {}
                    Some(VisitState::InProgress) => return Err(GraphError::Circular { step: step.name, resource: read.resource }),
                    None => visit(read.resource, writers, states, order)?,
                }
            }
        }
        states.insert(resource, VisitState::Done);
        order.push(resource);
        Ok(())
    }
    let mut order = Vec::new();
    visit(image, writers, &mut BTreeMap::new(), &mut order)?;
    Ok(order)
}

/// Compiles the steps to a plan whose last pass creates `image`.
///
/// # Errors
/// See [`GraphError`].
pub(crate) fn compile(steps: &[PassStep], image: &'static str) -> Result<Plan, GraphError> {
    let mut creators: BTreeMap<&'static str, (&PassStep, &TargetDescriptor)> = BTreeMap::new();
    for step in steps {
        if let Write::New(target) = &step.writes
            && let Some((first, _)) = creators.insert(target.resource, (step, target))
        {
            return Err(GraphError::CreatedTwice { resource: target.resource, first: first.name, second: step.name });
        }
    }
    let mut writers: BTreeMap<&'static str, Vec<&PassStep>> = BTreeMap::new();
    for step in steps {
        for resource in step.reads.iter().map(|r| r.resource).chain([step.resource()]) {
            if !creators.contains_key(resource) {
                return Err(GraphError::NotCreated { step: step.name, resource });
            }
        }
        writers.entry(step.resource()).or_default().push(step);
    }
    if !creators.contains_key(image) {
        return Err(GraphError::NoImage(image));
    }
    let order = topological_order(&writers, image)?;
    // The order contains only resources on which the image depends, so a cycle among other resources is reported as unconnected, not as circular.
    if let Some(step) = steps.iter().find(|s| !order.contains(&s.resource())) {
        return Err(GraphError::Unconnected { step: step.name, resource: step.resource() });
    }
    // Every resource that a step reads is in the order, so 0 is never used.
    let pass_index_of = |resource: &str| order.iter().position(|r| *r == resource).unwrap_or(0);
    let passes = order.iter().map(|resource| {
        let (_, target) = creators[resource];
        let draws = writers[resource].iter().flat_map(|step| {
            step.draws.iter().map(|draw| {
                let mut draw = draw.clone();
                let texture_binding =
                    |r: &Read| TextureBinding { binding: r.binding, source: TextureSource::PassOutput(pass_index_of(r.resource)) };
                draw.textures.extend(step.reads.iter().map(texture_binding));
                draw
            })
        });
        Pass {
            name: target.resource,
            width: target.width,
            height: target.height,
            format: target.format,
            samples: target.samples,
            clear: target.clear,
            has_depth: target.has_depth,
            draws: draws.collect(),
        }
    });
    Ok(Plan { passes: passes.collect() })
}

/// Lists passes, steps and draws in drawing order, as text.
pub(crate) fn listing(steps: &[PassStep], plan: &Plan) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let mut text = String::new();
    for (k, pass) in plan.passes.iter().enumerate() {
        let depth = if pass.has_depth { ", depth" } else { "" };
        text.push_str(&format!(
            "pass {k} makes {}: {}x{}, {:?}, {} sample{}{depth}\n",
            pass.name,
            pass.width,
            pass.height,
            pass.format,
            pass.samples,
            plural(pass.samples.into())
        ));
        for step in steps.iter().filter(|s| s.resource() == pass.name) {
            let reads: Vec<&str> = step.reads.iter().map(|r| r.resource).collect();
            let reads = if reads.is_empty() { String::new() } else { format!(", reads {}", reads.join(", ")) };
            let labels: Vec<String> = step.draws.iter().map(|d| format!("{} ({})", d.label, d.module)).collect();
            text.push_str(&format!("  {}: {} draw{}{reads}\n", step.name, step.draws.len(), plural(step.draws.len())));
            labels.iter().for_each(|l| text.push_str(&format!("    {l}\n")));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn creates(name: &'static str, resource: &'static str, reads: &[&'static str]) -> PassStep {
        let target = TargetDescriptor {
            resource,
            width: 4,
            height: 4,
            format: ColourFormat::Rgba8Unorm,
            samples: 1,
            clear: [0.0; 4],
            has_depth: false,
        };
        PassStep {
            name,
            reads: reads.iter().map(|resource| Read { resource, binding: 1 }).collect(),
            writes: Write::New(target),
            draws: vec![],
        }
    }

    fn over(name: &'static str, resource: &'static str, reads: &[&'static str]) -> PassStep {
        PassStep { writes: Write::Over(resource), ..creates(name, resource, reads) }
    }

    fn names(steps: &[PassStep]) -> Vec<&'static str> {
        compile(steps, "image").expect("a plan").passes.iter().map(|p| p.name).collect()
    }

    #[test]
    fn a_resource_is_created_before_it_is_read_in_any_declaration_order() {
        let steps =
            [creates("tone map", "image", &["light", "halo"]), creates("blur", "halo", &["light"]), creates("bodies", "light", &[])];
        assert_eq!(names(&steps), ["light", "halo", "image"]);
        let reversed: Vec<PassStep> = steps.iter().rev().cloned().collect();
        assert_eq!(names(&reversed), ["light", "halo", "image"]);
        // A step that draws over a resource adds no pass.
        assert_eq!(
            names(&[creates("bodies", "light", &[]), over("points", "light", &[]), creates("tone map", "image", &["light"])]),
            ["light", "image"]
        );
    }

    #[test]
    fn each_error_names_its_step_or_the_image() {
        let why = |steps: &[PassStep]| compile(steps, "image").expect_err("a mistake").to_string();
        let tone_map = || creates("tone map", "image", &["light"]);
        assert!(why(&[creates("a", "light", &[]), creates("b", "light", &[]), tone_map()]).contains("`a` and `b` both create `light`"));
        assert!(why(&[tone_map()]).contains("`tone map` needs `light`"));
        assert!(why(&[over("points", "stars", &[])]).contains("`points` needs `stars`"));
        assert!(why(&[creates("a", "light", &[]), creates("lost", "mask", &[]), tone_map()]).contains("`lost` draws into `mask`"));
        assert!(why(&[creates("a", "light", &["mask"]), creates("m", "mask", &["light"]), tone_map()]).contains("not finished before"));
        assert!(why(&[creates("a", "light", &["light"]), tone_map()]).contains("not finished before"));
        assert!(why(&[creates("a", "light", &[])]).contains("no step creates the image"));
        let cycle = [creates("a", "light", &[]), tone_map(), creates("m", "mask", &["other"]), creates("o", "other", &["mask"])];
        assert!(why(&cycle).contains("`m` draws into `mask`"));
    }
}
