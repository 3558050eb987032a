#include "map_server/map_server_process.h"

#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <QTimer>

#include "map_server/map_progress.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t LINES_KEPT = 20;
constexpr std::size_t LINES_WAITING = 1000;
constexpr int LINE_LENGTH = 2000;

/// The sockets and files of RViz are not for its child: it would keep them open. In the child
/// between fork and exec, where only what is safe in signal handlers may be called.
void closeAllOnExec()
{
#ifdef SYS_close_range
  constexpr unsigned int ONLY_ON_EXEC = 4;  // CLOSE_RANGE_CLOEXEC: Qt still needs one of them
  if (::syscall(SYS_close_range, 3U, ~0U, ONLY_ON_EXEC) == 0) {
    return;
  }
#endif
  const long limit = ::sysconf(_SC_OPEN_MAX);
  const int end = limit > 0 && limit < 65536 ? static_cast<int>(limit) : 65536;
  for (int file = 3; file < end; ++file) {
    ::fcntl(file, F_SETFD, FD_CLOEXEC);
  }
}

std::string howEnded(int code, QProcess::ExitStatus status)
{
  if (status == QProcess::NormalExit) {
    return "exit code " + std::to_string(code);
  }
  const char* name = ::strsignal(code);
  return "signal " + std::to_string(code) + (name ? std::string(" (") + name + ")" : "");
}

}  // namespace

MapServerProcess::MapServerProcess(const QString& program, const QStringList& arguments,
                                   const QStringList& environment, std::chrono::milliseconds grace)
    : grace_(grace), parent_id_(::getpid())
{
  setProcessChannelMode(QProcess::MergedChannels);
  setStandardInputFile(QProcess::nullDevice());
  setEnvironment(QProcess::systemEnvironment() + environment);
  connect(this, &QProcess::readyReadStandardOutput, [this] { read(); });
  connect(this, &QProcess::errorOccurred, [this](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) {
      end("it cannot be started: " + errorString().toStdString());
    }
  });
  connect(this, static_cast<void (QProcess::*)(int, QProcess::ExitStatus)>(&QProcess::finished),
          [this](int code, QProcess::ExitStatus status) {
            read();
            take(readAll());
            end(howEnded(code, status));
          });
  start(program, arguments);
}

/// Where Qt's event loop has ended for good, the system ends the process.
void MapServerProcess::Abandon::operator()(MapServerProcess* process) const
{
  process->abandoned_ = true;
  if (process->ended()) {
    process->deleteLater();
    return;
  }
  process->terminate();
  QTimer::singleShot(process->grace_, process, [process] { process->kill(); });
}

void MapServerProcess::setupChildProcess()
{
  closeAllOnExec();
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    ::signal(number, SIG_DFL);
  }
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent_id_) {
    ::_exit(1);  // it has ended before that was said
  }
}

void MapServerProcess::read()
{
  setReadChannel(QProcess::StandardOutput);
  while (canReadLine()) {
    take(readLine());
  }
  if (bytesAvailable() > LINE_LENGTH) {
    take(readAll());
  }
}

void MapServerProcess::take(const QByteArray& bytes)
{
  const std::string line = plainLine(bytes.left(LINE_LENGTH).toStdString());
  if (line.empty() || abandoned_) {
    return;
  }
  last_.push_back(line);
  if (last_.size() > LINES_KEPT) {
    last_.erase(last_.begin());
  }
  if (waiting_.size() < LINES_WAITING) {
    waiting_.push_back(line);
  }
}

void MapServerProcess::end(const std::string& how)
{
  ending_ = how;
  if (abandoned_) {
    deleteLater();
  }
}

std::vector<std::string> MapServerProcess::takeLines()
{
  return std::exchange(waiting_, {});
}

}  // namespace rviz_mesh_plugin
