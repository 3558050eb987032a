#include "osmesa_harness/crash_report.h"

#include <execinfo.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstring>

#include <gtest/gtest.h>

namespace osmesa_harness {
namespace {

constexpr int SIGNALS[] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};
constexpr int MOST_FRAMES = 100;

/// Of the test that runs; written by the thread of the tests, read by whichever crashes.
char current_test[256] = "no test";
std::atomic_flag is_reporting = ATOMIC_FLAG_INIT;

/// Also where the stack itself is what ran out: of the thread of the tests.
alignas(16) char signal_stack[64 * 1024];

class CurrentTest : public testing::EmptyTestEventListener
{
  void OnTestStart(const testing::TestInfo& test) override
  {
    std::snprintf(current_test, sizeof(current_test), "%s.%s", test.test_suite_name(), test.name());
  }
  void OnTestEnd(const testing::TestInfo& /*test*/) override
  {
    std::strcpy(current_test, "no test");
  }
};

void write(const char* text)
{
  // Nothing can be done where even this fails.
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
}

void writeNumber(int number)
{
  char digits[4] = {};  // signals have two
  std::size_t at = sizeof(digits) - 1;
  do {
    digits[--at] = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number > 0 && at > 0);
  write(digits + at);
}

/// All signals are blocked meanwhile: a fault in here ends the process at once.
void report(int number)
{
  if (is_reporting.test_and_set()) {
    for (;;) {  // another thread reports, and then ends all
      pause();
    }
  }
  write("\ncrash: signal ");
  writeNumber(number);
  write(" in ");
  write(current_test);
  write(", native stack of its thread:\n");
  void* frames[MOST_FRAMES];
  backtrace_symbols_fd(frames, backtrace(frames, MOST_FRAMES), STDERR_FILENO);
  write("crash: end of the stack\n");
  std::signal(number, SIG_DFL);
  std::raise(number);  // once this returns
}

}  // namespace

void reportCrashes()
{
  // The first call loads a library, which the handler must not.
  void* frame[1];
  backtrace(frame, 1);
  testing::UnitTest::GetInstance()->listeners().Append(new CurrentTest);
  stack_t stack{};
  stack.ss_sp = signal_stack;
  stack.ss_size = sizeof(signal_stack);
  sigaltstack(&stack, nullptr);
  struct sigaction action
  {
  };
  action.sa_handler = report;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (const int number : SIGNALS) {
    struct sigaction before
    {
    };
    sigaction(number, nullptr, &before);
    if (before.sa_handler == SIG_DFL) {
      sigaction(number, &action, nullptr);
    }
  }
}

}  // namespace osmesa_harness
