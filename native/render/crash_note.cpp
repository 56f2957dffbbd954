// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/crash_note.h"

#if defined(__unix__) || defined(__APPLE__)
#include <signal.h>
#include <unistd.h>

#include <array>
#include <mutex>
#endif

namespace penumbra {
namespace {

thread_local const Rectangle* rendering = nullptr;

#if defined(__unix__) || defined(__APPLE__)

constexpr std::array kSignals{SIGSEGV, SIGBUS, SIGILL, SIGABRT, SIGFPE};
std::array<struct sigaction, kSignals.size()> before;

/// Only what a signal handler may call: no allocation, no formatting library.
class Line {
 public:
  Line& operator<<(const char* text) {
    while (*text && size_ < sizeof(text_)) text_[size_++] = *text++;
    return *this;
  }
  Line& operator<<(uint32_t number) {
    char digits[11] = {};
    char* p = digits + 10;
    do *--p = char('0' + number % 10);
    while (number /= 10);
    return *this << p;
  }
  void write() const {
    if (::write(STDERR_FILENO, text_, size_) < 0) return;  // nobody is left to be told
  }

 private:
  char text_[256];
  size_t size_ = 0;
};

void on_crash(int signal) {
  if (const Rectangle* r = rendering) {
    Line line;
    line << "Penumbra: crashed in the pixels " << r->x << "," << r->y << " to " << r->x + r->width - 1 << ","
         << r->y + r->height - 1 << "; look at one with: render.py --debug-pixel " << r->x << "," << r->y
         << "\n";
    line.write();
  }
  for (size_t i = 0; i < kSignals.size(); ++i)
    if (kSignals[i] == signal) sigaction(signal, &before[i], nullptr);
  raise(signal);
}

#endif

}  // namespace

void install_crash_note() {
#if defined(__unix__) || defined(__APPLE__)
  static std::once_flag once;
  std::call_once(once, [] {
    struct sigaction action = {};
    action.sa_handler = on_crash;
    action.sa_flags = SA_ONSTACK | SA_NODEFER;
    for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before[i]);
  });
#endif
}

CrashNote::CrashNote(const Rectangle& block) {
  rendering = &block;
}

CrashNote::~CrashNote() {
  rendering = nullptr;
}

}  // namespace penumbra
