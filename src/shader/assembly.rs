//! SPIR-V words as text, an instruction a line, for readers.
//!
//! In: the words of a module as naga writes them. Out: lines such as `%12 = OpFAdd %3 %10 %11`. Always: every instruction has its line; one whose
//! operands are not known to this file is written with its operands as numbers of values. It validates nothing.

use spirv::Op;
use std::collections::BTreeMap;

/// Words before the first instruction.
const HEADER: usize = 5;

/// What an operand is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Id,
    Number,
    Text,
}

/// What numbers of a type are, so that constants can be read.
#[derive(Clone, Copy)]
enum Scalar {
    Float,
    Signed,
    Unsigned,
}

/// The module as text.
pub fn assembly(words: &[u32]) -> String {
    let mut text = String::new();
    let mut scalars = BTreeMap::new();
    let mut rest = words.get(HEADER..).unwrap_or_default();
    if let [_, version, _, bound, ..] = *words {
        text.push_str(&format!("; SPIR-V {}.{}, ids below {bound}\n", version >> 16, version >> 8 & 0xff));
    }
    while let Some(&first) = rest.first() {
        let (length, opcode) = ((first >> 16) as usize, first & 0xffff);
        let Some(operands) = rest.get(1..length) else {
            text.push_str("; the words end within an instruction\n");
            break;
        };
        text.push_str(&instruction(opcode, operands, &mut scalars));
        rest = &rest[length..];
    }
    text
}

fn instruction(opcode: u32, operands: &[u32], scalars: &mut BTreeMap<u32, Scalar>) -> String {
    let Some(op) = Op::from_u32(opcode) else { return format!("; opcode {opcode} {operands:?}\n") };
    match (op, operands) {
        (Op::TypeFloat, [id, ..]) => drop(scalars.insert(*id, Scalar::Float)),
        (Op::TypeInt, [id, _, 0]) => drop(scalars.insert(*id, Scalar::Unsigned)),
        (Op::TypeInt, [id, ..]) => drop(scalars.insert(*id, Scalar::Signed)),
        _ => {}
    }
    let results = results(op);
    let (heads, tail) = operands.split_at(results.min(operands.len()));
    // A type comes before its value.
    let (result, ty) = match heads {
        [id] => (Some(id), None),
        [ty, id] => (Some(id), Some(ty)),
        _ => (None, None),
    };
    let mut line = result.map_or(String::new(), |id| format!("%{id} = "));
    line.push_str(&format!("Op{op:?}"));
    ty.iter().for_each(|ty| line.push_str(&format!(" %{ty}")));
    let mut at = 0;
    while at < tail.len() {
        let (kind, left) = (kind(op, at), &tail[at..]);
        match kind {
            Kind::Id => line.push_str(&format!(" %{}", left[0])),
            Kind::Number => line.push_str(&format!(" {}", number(op, at, left[0], ty.and_then(|t| scalars.get(t))))),
            Kind::Text => {
                let (string, length) = string(left);
                line.push_str(&format!(" {string:?}"));
                at += length - 1;
            }
        }
        at += 1;
    }
    line.push('\n');
    // Blocks and functions stand apart.
    if op == Op::Function { format!("\n{line}") } else { line }
}

/// 0: makes no value, 1: makes an id without a type, 2: a type's id and its own.
fn results(op: Op) -> usize {
    match op {
        Op::Capability
        | Op::Extension
        | Op::MemoryModel
        | Op::EntryPoint
        | Op::ExecutionMode
        | Op::Source
        | Op::SourceExtension
        | Op::Name
        | Op::MemberName
        | Op::Decorate
        | Op::MemberDecorate
        | Op::ModuleProcessed
        | Op::Line
        | Op::NoLine
        | Op::Store
        | Op::CopyMemory
        | Op::Branch
        | Op::BranchConditional
        | Op::Switch
        | Op::Return
        | Op::ReturnValue
        | Op::Kill
        | Op::Unreachable
        | Op::FunctionEnd
        | Op::SelectionMerge
        | Op::LoopMerge
        | Op::ImageWrite
        | Op::ControlBarrier
        | Op::MemoryBarrier
        | Op::Nop => 0,
        Op::Label | Op::String | Op::ExtInstImport => 1,
        _ if format!("{op:?}").starts_with("Type") => 1,
        _ => 2,
    }
}

/// What the operand after the result ids is, counted from 0.
fn kind(op: Op, at: usize) -> Kind {
    let numbers_from = |first: usize| if at >= first { Kind::Number } else { Kind::Id };
    match op {
        Op::Capability | Op::MemoryModel | Op::TypeInt | Op::TypeFloat | Op::Constant => Kind::Number,
        Op::Extension | Op::ExtInstImport | Op::String | Op::SourceExtension | Op::ModuleProcessed => Kind::Text,
        Op::EntryPoint if at == 0 => Kind::Number,
        Op::EntryPoint if at == 2 => Kind::Text,
        Op::Name if at == 1 => Kind::Text,
        Op::MemberName if at == 2 => Kind::Text,
        Op::MemberName | Op::ExecutionMode | Op::Decorate | Op::MemberDecorate => numbers_from(1),
        Op::TypeVector | Op::TypeMatrix | Op::TypeImage | Op::SelectionMerge | Op::CompositeExtract | Op::Load => numbers_from(1),
        Op::TypePointer | Op::Variable | Op::Function if at == 0 => Kind::Number,
        Op::CompositeInsert
        | Op::VectorShuffle
        | Op::Store
        | Op::LoopMerge
        | Op::ImageSampleImplicitLod
        | Op::ImageSampleExplicitLod
        | Op::ImageFetch => match (op, at) {
            // A mask, then what it announces.
            (Op::ImageSampleImplicitLod | Op::ImageSampleExplicitLod | Op::ImageFetch, 3..) => Kind::Id,
            _ => numbers_from(2),
        },
        Op::ExtInst if at == 1 => Kind::Number,
        Op::Switch if at >= 2 && at.is_multiple_of(2) => Kind::Number,
        _ => Kind::Id,
    }
}

fn number(op: Op, at: usize, word: u32, scalar: Option<&Scalar>) -> String {
    let named = |name: Option<String>| name.unwrap_or_else(|| word.to_string());
    match (op, at) {
        (Op::Constant, _) => match scalar {
            Some(Scalar::Float) => format!("{:?}", f32::from_bits(word)),
            Some(Scalar::Signed) => word.cast_signed().to_string(),
            _ => word.to_string(),
        },
        (Op::Capability, _) => named(spirv::Capability::from_u32(word).map(|c| format!("{c:?}"))),
        (Op::Decorate, 1) | (Op::MemberDecorate, 2) => named(spirv::Decoration::from_u32(word).map(|d| format!("{d:?}"))),
        (Op::TypePointer | Op::Variable, 0) => named(spirv::StorageClass::from_u32(word).map(|c| format!("{c:?}"))),
        (Op::EntryPoint, 0) => named(spirv::ExecutionModel::from_u32(word).map(|m| format!("{m:?}"))),
        (Op::ExecutionMode, 1) => named(spirv::ExecutionMode::from_u32(word).map(|m| format!("{m:?}"))),
        // naga imports GLSL.std.450 and nothing else.
        (Op::ExtInst, 1) => named(spirv::GlslStd450Op::from_u32(word).map(|o| format!("{o:?}"))),
        _ => word.to_string(),
    }
}

/// Letters, four a word, ended by a zero; and how many words they take.
fn string(words: &[u32]) -> (String, usize) {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    (String::from_utf8_lossy(&bytes[..end]).into_owned(), (end / 4 + 1).min(words.len()).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_module_reads_as_the_specification_writes_it() {
        // By hand from the SPIR-V specification: OpTypeFloat 22, OpConstant 43, OpFAdd 129, OpName 5.
        let words = [
            0x0723_0203,
            0x0001_0100,
            0,
            9,
            0,
            3 << 16 | 22,
            1,
            32,
            4 << 16 | 43,
            1,
            2,
            1.5f32.to_bits(),
            5 << 16 | 129,
            1,
            3,
            2,
            2,
            4 << 16 | 5,
            3,
            u32::from_le_bytes(*b"abcd"),
            0,
        ];
        let text = assembly(&words);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[1..], ["%1 = OpTypeFloat 32", "%2 = OpConstant %1 1.5", "%3 = OpFAdd %1 %2 %2", "OpName %3 \"abcd\""]);
        assert!(lines[0].contains("1.1"));
        assert!(assembly(&words[..words.len() - 1]).contains("end within"), "cut short");
        assert!(assembly(&[1, 2]).is_empty());
    }
}
