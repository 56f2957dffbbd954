// SPDX-License-Identifier: GPL-3.0-or-later
// If the process dies in a render, its last words say in which pixels.
#pragma once

#include "render/settings.h"

namespace penumbra {

/// Takes over the signals of a crash (segmentation fault, bus error, illegal instruction, abort, arithmetic),
/// once a process. A thread that is rendering then writes its block and how to look at it to stderr; whoever
/// had the signal before gets it next. Does nothing where there are no such signals.
void install_crash_note();

/// While it lives, its thread is rendering this block (full frame).
class CrashNote {
 public:
  explicit CrashNote(const Rectangle& block);
  ~CrashNote();
  CrashNote(const CrashNote&) = delete;
  CrashNote& operator=(const CrashNote&) = delete;
};

}  // namespace penumbra
