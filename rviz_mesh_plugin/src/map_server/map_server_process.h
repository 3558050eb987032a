#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <QProcess>

namespace rviz_mesh_plugin {

/// A child process that ends with its owner, and with this process in whatever way that ends. GUI
/// thread only (it is the death of the starting thread that ends the child); nothing waits.
class MapServerProcess : public QProcess
{
 public:
  /// Asks it to end (SIGTERM); if it has not when the grace is over, it is killed. The object
  /// outlives its owner until then.
  struct Abandon
  {
    void operator()(MapServerProcess* process) const;
  };
  using Owner = std::unique_ptr<MapServerProcess, Abandon>;

  /// Starts it without a shell, in this process's environment.
  /// @param environment "NAME=value", on top of that
  /// @param grace time to end, and before that to save
  MapServerProcess(const QString& program, const QStringList& arguments,
                   const QStringList& environment,
                   std::chrono::milliseconds grace = std::chrono::seconds(15));

  bool ended() const { return !ending_.empty(); }

  /// How it has ended, as "exit code 1" or "signal 9 (Killed)"; empty while it runs.
  const std::string& ending() const { return ending_; }

  /// Lines that it has written since the last call, on stdout and stderr.
  std::vector<std::string> takeLines();

  /// The newest lines, some 20 at most.
  const std::vector<std::string>& lastLines() const { return last_; }

 protected:
  void setupChildProcess() override;

 private:
  void read();
  void take(const QByteArray& bytes);
  void end(const std::string& how);

  const std::chrono::milliseconds grace_;
  const pid_t parent_id_;
  bool abandoned_ = false;
  std::vector<std::string> waiting_;
  std::vector<std::string> last_;
  std::string ending_;
};

}  // namespace rviz_mesh_plugin
