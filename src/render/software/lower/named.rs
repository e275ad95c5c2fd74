//! Adds named intermediate values to the outputs of a program, for inspecting a pixel.
//!
//! In: a module and an entry point. Out: its program with one more output for each scalar of every named value. Named values are each `let`, and
//! each variable when its function returns. Names in a called function are prefixed with the function's name and a slash; a second call in the same
//! caller has the prefix `name#2`. In a loop the value of the last iteration is output. A value that the pixel's control flow does not reach is NaN.
//! Programs that draw images have none of these outputs.

use super::error::Result;
use super::lowerer::Lowerer;
use super::step::{Step, Val};
use super::value::Value;
use super::watch::CapturedValue;
use crate::render::software::tape::Op;
use naga::{Expression, Handle, ScalarKind, Statement, TypeInner};

/// Values with more scalars than this are tables and are not output.
const MAX_SCALARS: usize = 16;

impl<'m> Lowerer<'m> {
    pub(crate) fn watch_enter(&mut self, callee: Option<&str>, call: &'m Statement) {
        let Some(watch) = &mut self.watch else { return };
        let callee = callee.unwrap_or("?").to_owned();
        let sites = watch.calls.entry((watch.call_path.join("/"), callee.clone())).or_default();
        // The address of a call statement identifies it, since the module is borrowed during lowering.
        let site = std::ptr::from_ref(call).addr();
        let at = sites.iter().position(|s| *s == site).unwrap_or_else(|| {
            sites.push(site);
            sites.len() - 1
        });
        watch.call_path.push(if at == 0 { callee } else { format!("{callee}#{}", at + 1) });
    }

    pub(crate) fn watch_leave(&mut self) {
        if let Some(watch) = &mut self.watch {
            watch.call_path.pop();
        }
    }

    /// Captures an expression's value if it has a name.
    pub(crate) fn watch_value(&mut self, handle: Handle<Expression>, value: &Value) -> Result<()> {
        let (Some(_), Value::Scalars(scalars)) = (&self.watch, value) else { return Ok(()) };
        let frame = self.frame();
        let Some(name) = frame.function.named_expressions.get(&handle) else { return Ok(()) };
        let inner = frame.info[handle].ty.inner_with(&self.module.types).clone();
        self.capture(name.clone(), &inner, scalars)
    }

    /// Captures the variables of a function when it returns.
    pub(crate) fn watch_variables(&mut self) -> Result<()> {
        if self.watch.is_none() {
            return Ok(());
        }
        let function = self.frame().function;
        for (handle, local) in function.local_variables.iter() {
            let (Some(name), Some(at)) = (&local.name, self.frame().locals.get(&handle).copied()) else { continue };
            let inner = &self.module.types[local.ty].inner;
            let scalars = self.env[at..at + self.scalar_count(inner)?].to_vec();
            self.capture(name.clone(), inner, &scalars)?;
        }
        Ok(())
    }

    fn capture(&mut self, name: String, inner: &TypeInner, scalars: &[Val]) -> Result<()> {
        if let TypeInner::Struct { members, .. } = inner {
            let mut at = 0;
            for m in members {
                let of_member = &self.module.types[m.ty].inner;
                let count = self.scalar_count(of_member)?;
                self.capture(format!("{name}.{}", m.name.as_deref().unwrap_or("?")), of_member, &scalars[at..at + count])?;
                at += count;
            }
            return Ok(());
        }
        let Some(kind) = inner.scalar_kind().filter(|_| scalars.len() <= MAX_SCALARS) else { return Ok(()) };
        let (one, zero) = (self.builder.float(1.0), self.builder.float(0.0));
        let numbers: Vec<Val> = scalars
            .iter()
            .map(|v| match kind {
                ScalarKind::Bool => self.builder.select(*v, one, zero),
                ScalarKind::Sint => self.builder.un(Op::FFromI, *v),
                ScalarKind::Uint => self.builder.un(Op::FFromU, *v),
                _ => *v,
            })
            .collect();
        let fresh: Vec<Val> = numbers.iter().map(|_| self.builder.fresh_lane()).collect();
        let Some(watch) = &mut self.watch else { return Ok(()) };
        let name = watch.call_path.iter().cloned().chain([name]).collect::<Vec<_>>().join("/");
        let at = *watch.index_of.entry(name.clone()).or_insert_with(|| {
            watch.captured.push(CapturedValue { name, lanes: fresh });
            watch.captured.len() - 1
        });
        let lanes = watch.captured[at].lanes.clone();
        for (dst, v) in lanes.into_iter().zip(numbers) {
            // Inactive lanes keep their earlier value.
            let from = self.builder.select(self.active_mask, v, dst);
            self.builder.code.push(Step::Assign { dst, from });
        }
        Ok(())
    }
}
