// Runs the executable with every row of the tables in docs/errors.md.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/images.h"

namespace {

namespace fs = std::filesystem;

// Sanitizers reserve terabytes of address space, so it cannot be limited.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif
#else
constexpr bool sanitized = false;
#endif

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Row {
  std::string name, file, command, message;
  int code = 0;

  bool limited() const { return command.starts_with("ulimit"); }
};

struct Limit {
  __rlimit_resource what = RLIMIT_AS;
  rlim_t value = 0;  // 0: no limit
};

struct Document {
  std::string scene;  // for rows without their own file
  std::vector<Row> rows;
};

/// \return the contents of a cell, without blanks and backticks around them.
std::string bare(const std::string& cell) {
  const auto first = cell.find_first_not_of(" `"), last = cell.find_last_not_of(" `");
  return first == cell.npos ? "" : cell.substr(first, last - first + 1);
}

Document read_document(const fs::path& path) {
  Document document;
  std::ifstream file(path);
  bool in_scene = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      in_scene = line == "```json";
    } else if (in_scene) {
      document.scene += line + "\n";
    }
    std::vector<std::string> cells;
    std::istringstream columns(line);
    for (std::string cell; std::getline(columns, cell, '|');) cells.push_back(bare(cell));
    if (cells.size() != 6 || cells[1] == "case" || cells[1].starts_with("---")) continue;
    document.rows.push_back({cells[1], cells[2], cells[3], cells[5], std::stoi(cells[4])});
  }
  return document;
}

class ErrorsTable : public testing::Test {
 protected:
  void SetUp() override {
    const char* binary = std::getenv("TYNDALL_BINARY");
    const char* source = std::getenv("TYNDALL_SOURCE_DIR");
    if (!binary || !source) GTEST_SKIP() << "TYNDALL_BINARY or TYNDALL_SOURCE_DIR is not set";
    binary_ = binary;
    document_ = read_document(fs::path(source) / "docs" / "errors.md");
    ASSERT_GE(document_.rows.size(), 50u);
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    scratch_ = name;
    fs::create_directory(scratch_ / "work");
  }
  void TearDown() override {
    if (!scratch_.empty()) fs::remove_all(scratch_);
  }

  void try_row(const Row& row) const {
    SCOPED_TRACE(row.name + ": " + row.command);
    const std::string text = row.file.empty() ? document_.scene : row.file;
    std::ofstream(scratch_ / "work" / "scene.json") << (text == "(empty)" ? "" : text);
    const std::vector<float> densities(8, 1.0f);
    std::ofstream(scratch_ / "work" / "density.raw", std::ios::binary)
        .write(reinterpret_cast<const char*>(densities.data()), 8 * sizeof(float));
    using namespace tyndall::test;
    const auto put = [&](const char* image, const ExrPart& part) {
      std::ofstream(scratch_ / "work" / image, std::ios::binary) << exr_file({part});
    };
    ExrPart part;
    part.channels = exr_rgb("day", 1, 1, 1);
    for (const ExrChannel& channel : exr_rgb("night", 0, 0, 0)) part.channels.push_back(channel);
    put("layers.exr", part);
    part.channels = exr_rgb("", 1, 1, 1);
    part.attributes = exr_attribute("envmap", "envmap", std::string(1, '\1'));
    put("cube.exr", part);
    part.attributes = "";
    part.channels[2].value = [](int x, int y) {
      return x == 3 && y == 2 ? std::numeric_limits<float>::infinity() : 1.0f;
    };
    put("infinite.exr", part);

    std::istringstream words(row.command);
    std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
    Limit limit;
    if (row.limited()) {
      ASSERT_GT(arguments.size(), 3u);
      const rlim_t value = std::stoul(arguments[2]);  // "4000000;"
      if (arguments[1] == "-v")
        limit = {RLIMIT_AS, value * 1024};
      else if (arguments[1] == "-n")
        limit = {RLIMIT_NOFILE, value};
      else
        FAIL() << arguments[1];
      arguments.erase(arguments.begin(), arguments.begin() + 3);
    }
    ASSERT_FALSE(arguments.empty());
    ASSERT_EQ(arguments[0], "tyndall");
    EXPECT_EQ(run(arguments, limit), row.code);
    const std::string printed = contents(scratch_ / "printed");
    EXPECT_NE(printed.find(row.message), std::string::npos) << "printed:\n" << printed;
    // A picture exists exactly if the render was done.
    const bool rendered = arguments[1] == "render" && row.code == 0;
    EXPECT_EQ(fs::remove(scratch_ / "work" / "cloud.pfm"), rendered);
  }

  Document document_;

 private:
  /// Runs a command with its output redirected to a file. \return the exit code, -1 after a crash
  int run(std::vector<std::string>& arguments, Limit limit) const {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string folder = scratch_ / "work", printed = scratch_ / "printed";
    const pid_t child = ::fork();
    if (child == 0) {
      const int file = ::open(printed.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      ::dup2(file, STDOUT_FILENO);
      ::dup2(file, STDERR_FILENO);
      ::close(file);
      const rlimit bound{limit.value, limit.value};
      if (limit.value > 0) ::setrlimit(limit.what, &bound);
      if (::chdir(folder.c_str()) == 0) ::execv(binary_.c_str(), argv.data());
      ::_exit(127);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::string binary_;
  fs::path scratch_;
};

TEST_F(ErrorsTable, EveryRowIsTrue) {
  for (const Row& row : document_.rows) {
    if (!row.limited()) try_row(row);
  }
}

TEST_F(ErrorsTable, EveryRowWithALimitIsTrue) {
  if (sanitized) GTEST_SKIP() << "sanitizers take more address space than any limit";
  for (const Row& row : document_.rows) {
    if (row.limited()) try_row(row);
  }
}

}  // namespace
