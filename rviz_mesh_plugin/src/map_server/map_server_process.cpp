#include "map_server/map_server_process.h"

#include <csignal>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <QProcess>
#include <QProcessEnvironment>
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

/// Outlives its owner until the process has ended.
class MapServerProcess::Child : public QProcess
{
 public:
  Child(const QString& program, const QStringList& arguments,
        const QProcessEnvironment& environment, std::chrono::milliseconds grace)
      : grace_(grace), parent_id_(::getpid())
  {
    setProcessChannelMode(QProcess::MergedChannels);
    setStandardInputFile(QProcess::nullDevice());
    setProcessEnvironment(environment);
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

  /// Ends the process and then itself. Where Qt's event loop has ended for good, the system ends
  /// the process.
  void abandon()
  {
    abandoned_ = true;
    if (!ending.empty()) {
      deleteLater();
      return;
    }
    terminate();
    QTimer::singleShot(grace_, this, [this] { kill(); });
  }

  std::vector<std::string> waiting;
  std::vector<std::string> last;
  std::string ending;

 protected:
  void setupChildProcess() override
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

 private:
  void read()
  {
    setReadChannel(QProcess::StandardOutput);
    while (canReadLine()) {
      take(readLine());
    }
    if (bytesAvailable() > LINE_LENGTH) {
      take(readAll());
    }
  }

  void take(const QByteArray& bytes)
  {
    const std::string line = plainLine(bytes.left(LINE_LENGTH).toStdString());
    if (line.empty() || abandoned_) {
      return;
    }
    last.push_back(line);
    if (last.size() > LINES_KEPT) {
      last.erase(last.begin());
    }
    if (waiting.size() < LINES_WAITING) {
      waiting.push_back(line);
    }
  }

  void end(const std::string& how)
  {
    ending = how;
    if (abandoned_) {
      deleteLater();
    }
  }

  const std::chrono::milliseconds grace_;
  const pid_t parent_id_;
  bool abandoned_ = false;
};

MapServerProcess::MapServerProcess(const std::string& program,
                                   const std::vector<std::string>& arguments,
                                   const std::vector<std::string>& environment,
                                   std::chrono::milliseconds grace)
{
  QStringList list;
  for (const std::string& argument : arguments) {
    list << QString::fromStdString(argument);
  }
  QProcessEnvironment variables = QProcessEnvironment::systemEnvironment();
  for (const std::string& variable : environment) {
    const std::size_t equals = variable.find('=');
    variables.insert(QString::fromStdString(variable.substr(0, equals)),
                     QString::fromStdString(variable.substr(equals + 1)));
  }
  child_ = new Child(QString::fromStdString(program), list, variables, grace);
}

MapServerProcess::~MapServerProcess()
{
  child_->abandon();
}

std::int64_t MapServerProcess::pid() const
{
  return child_->processId();
}

bool MapServerProcess::ended() const
{
  return !child_->ending.empty();
}

const std::string& MapServerProcess::ending() const
{
  return child_->ending;
}

std::vector<std::string> MapServerProcess::takeLines()
{
  std::vector<std::string> lines;
  lines.swap(child_->waiting);
  return lines;
}

const std::vector<std::string>& MapServerProcess::lastLines() const
{
  return child_->last;
}

}  // namespace rviz_mesh_plugin
