// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <set>
#include <unordered_map>

#include "material/evaluate.h"

namespace penumbra {
namespace {

using Names = std::unordered_map<std::string, const NamedOperation*>;

const Names& names() {
  static const Names all = [] {
    Names result;
    for (const auto& family :
         {input_operations(), math_operations(), vector_operations(), colour_operations(), mix_operations(),
          procedural_operations(), image_operations()})
      for (const NamedOperation& operation : family) result[operation.name] = &operation;
    return result;
  }();
  return all;
}

const NamedOperation& named(OperationFunction function) {
  const auto found = std::find_if(names().begin(), names().end(), [function](const auto& entry) {
    return entry.second->function == function;
  });
  return *found->second;  // programs are made of named operations alone
}

/// To be called when a program's operations have changed.
void note_what_it_looks_at(Program& program) {
  const std::vector<Operation>& all = program.operations;
  program.looks_beside = std::any_of(all.begin(), all.end(), [](const Operation& o) { return o.shift > 0; });
  program.looks_at_viewer = std::any_of(all.begin(), all.end(),
                                        [](const Operation& o) { return named(o.function).looks_at_viewer; });
}

}  // namespace

bool NamedOperation::fits(int32_t at, std::span<const float> tables, size_t images) const {
  if (data == DataKind::kNumber) return true;
  if (at < 0) return false;
  if (data == DataKind::kImage) return size_t(at) < images;
  if (size_t(at) >= tables.size()) return false;
  const std::span<const float> table = tables.subspan(size_t(at));
  if (data == DataKind::kMatrix) return table.size() >= 12;
  const size_t head = data == DataKind::kRamp ? 2 : 4, channels = data == DataKind::kRamp ? 4 : 3;
  const float places = table[0], least = data == DataKind::kRamp ? 1 : 2, most = 1 << 24;
  return places >= least && places <= most && table.size() >= head + channels * size_t(places);
}

const NamedOperation* find_operation(const std::string& name) {
  const auto found = names().find(name);
  return found == names().end() ? nullptr : found->second;
}

std::vector<std::string> operation_names() {
  std::vector<std::string> result;
  for (const auto& [name, operation] : names()) result.push_back(name);
  return result;
}

void fold(Program& program) {
  std::vector<bool> varies(program.registers.size(), false);
  std::vector<Operation> kept;
  Machine machine{};
  machine.registers = program.registers.data();
  machine.tables = program.tables.data();
  for (const Operation& operation : program.operations) {
    bool constant = named(operation.function).pure;
    for (const uint16_t input : operation.in) constant = constant && !varies[input];
    if (constant) {
      operation.function(machine, operation);
    } else {
      kept.push_back(operation);
      varies[operation.out] = true;
      if (operation.out + 1u < varies.size()) varies[operation.out + 1u] = true;
    }
  }
  program.operations = std::move(kept);
  note_what_it_looks_at(program);
}

Program part_of(const Program& program, ClosureKind kind) {
  Program result = program;
  std::erase_if(result.closures, [kind](const ClosureStep& c) { return c.kind != kind; });
  result.normal = 0;
  std::set<uint16_t> wanted;
  for (const ClosureStep& closure : result.closures) wanted.insert(closure.colour);
  std::vector<Operation> kept;
  for (auto operation = program.operations.rbegin(); operation != program.operations.rend(); ++operation) {
    if (!wanted.contains(operation->out) && !wanted.contains(uint16_t(operation->out + 1))) continue;
    kept.insert(kept.begin(), *operation);
    wanted.insert(operation->in.begin(), operation->in.end());
  }
  result.operations = std::move(kept);
  note_what_it_looks_at(result);
  return result;
}

}  // namespace penumbra
