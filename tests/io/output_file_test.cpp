#include "io/output_file.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// \return the exit code and the message of the error that `action` throws.
template <class Action>
std::pair<ExitCode, std::string> error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  return {ExitCode::done, ""};
}

class OutputFileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  /// Expects that opening `path` fails with `reason` and leaves no file behind.
  void expect_refused(const std::string& path, const std::string& reason) const {
    const std::size_t before = files();
    const auto [code, message] = error_of([&] { OutputFile file(path); });
    EXPECT_EQ(code, ExitCode::output_failed);
    EXPECT_NE(message.find(path), std::string::npos) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
    EXPECT_EQ(files(), before);
  }

  fs::path folder_;
};

TEST_F(OutputFileTest, ReplacesTheTargetAtCommitAndNotBefore) {
  put("a", "old");
  OutputFile file(folder_ / "a");
  file.write("ne");
  file.write("w");
  EXPECT_EQ(contents(folder_ / "a"), "old");
  file.commit();
  EXPECT_EQ(contents(folder_ / "a"), "new");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, KeepsTheOldFileIfAbandoned) {
  put("a", "old");
  {
    OutputFile file(folder_ / "a");
    file.write("half of the ne");
    EXPECT_EQ(files(), 2u);
  }
  EXPECT_EQ(contents(folder_ / "a"), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, MovesWithoutLosingItsTemporary) {
  OutputFile first(folder_ / "a");
  OutputFile second(std::move(first));
  second.write("x");
  second.commit();
  EXPECT_EQ(contents(folder_ / "a"), "x");
}

TEST_F(OutputFileTest, KeepsTheModeOfTheOldFile) {
  put("a", "old");
  fs::permissions(folder_ / "a", fs::perms{0664});
  OutputFile file(folder_ / "a");
  file.commit();
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::perms{0664});
}

TEST_F(OutputFileTest, FollowsLinksAndKeepsThem) {
  fs::create_directory(folder_ / "real");
  put("real/old", "old");
  fs::create_symlink("real/old", folder_ / "link");
  fs::create_symlink("real/new", folder_ / "dangling");
  for (const char* name : {"link", "dangling"}) {
    OutputFile file(folder_ / name);
    file.write("written");
    file.commit();
    EXPECT_TRUE(fs::is_symlink(folder_ / name));
  }
  EXPECT_EQ(contents(folder_ / "real/old"), "written");
  EXPECT_EQ(contents(folder_ / "real/new"), "written");
}

TEST_F(OutputFileTest, FailsAtOnceIfItCannotBeWritten) {
  expect_refused(folder_ / "missing" / "a", "does not exist");
  expect_refused(folder_, "it is a folder");
  expect_refused((folder_ / "new").string() + "/", "names a folder");
  expect_refused(folder_ / std::string(300, 'x'), "too long");
  expect_refused("/proc/a", "creating a file in '/proc'");
  put("a", "");
  expect_refused(folder_ / "a" / "b", "Not a directory");
  fs::create_symlink("loop", folder_ / "loop");
  expect_refused(folder_ / "loop", "links");
  EXPECT_EQ(error_of([] { OutputFile file(""); }).first, ExitCode::output_failed);
}

TEST_F(OutputFileTest, RespectsReadOnlyFilesAndFolders) {
  if (::geteuid() == 0) GTEST_SKIP() << "root ignores permissions";
  put("a", "old");
  fs::permissions(folder_ / "a", fs::perms{0444});
  expect_refused(folder_ / "a", "Permission denied");
  fs::permissions(folder_, fs::perms{0555});
  expect_refused(folder_ / "b", "Permission denied");
  fs::permissions(folder_, fs::perms{0755});
}

TEST_F(OutputFileTest, WritesDevicesDirectly) {
  OutputFile null("/dev/null");
  null.write("x");
  null.commit();
  OutputFile full("/dev/full");
  const auto [code, message] = error_of([&] {
    full.write("x");
    full.commit();
  });
  EXPECT_EQ(code, ExitCode::output_failed);
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
}

TEST_F(OutputFileTest, FailsIfTheFileGetsTooLarge) {
  put("a", "old");
  struct rlimit old {};
  ::getrlimit(RLIMIT_FSIZE, &old);
  struct rlimit small = old;
  small.rlim_cur = 1000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  const auto [code, message] = error_of([&] {
    OutputFile file(folder_ / "a");
    file.write(std::string(5000, 'x'));  // begins with a short write of 1000 bytes
    file.commit();
  });
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(code, ExitCode::output_failed);
  EXPECT_NE(message.find("too large"), std::string::npos) << message;
  EXPECT_EQ(contents(folder_ / "a"), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, RemovesTheTemporariesOfAllOpenOutputs) {
  OutputFile first(folder_ / "a"), second(folder_ / "b");
  OutputFile written(folder_ / "c");
  written.commit();
  EXPECT_EQ(files(), 3u);
  remove_temporaries();
  EXPECT_EQ(files(), 1u);
  EXPECT_TRUE(fs::exists(folder_ / "c"));
}

TEST_F(OutputFileTest, RemovesTemporariesOfKilledProcesses) {
  const auto age = [&](const std::string& name) {
    put(name, "half");
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() - std::chrono::minutes(2));
  };
  age(".tyndall-1-0.tmp");
  age("mine.tmp");
  put(".tyndall-2-0.tmp", "young");
  OutputFile living(folder_ / "a");
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.path() != folder_ / ".tyndall-2-0.tmp")
      fs::last_write_time(entry, fs::file_time_type::clock::now() - std::chrono::minutes(2));
  OutputFile other(folder_ / "b");
  EXPECT_FALSE(fs::exists(folder_ / ".tyndall-1-0.tmp"));
  EXPECT_TRUE(fs::exists(folder_ / "mine.tmp"));
  EXPECT_TRUE(fs::exists(folder_ / ".tyndall-2-0.tmp"));
  living.write("whole");
  living.commit();
  EXPECT_EQ(contents(folder_ / "a"), "whole");
}

}  // namespace
}  // namespace tyndall::io
