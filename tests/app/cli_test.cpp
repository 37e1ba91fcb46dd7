// Runs the executable as a shell does: exit codes, streams, files, signals.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Outcome {
  int code = -1;  // -1: ended by a signal or by this test's time limit
  std::string out, err;
};

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t count_lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

class CliTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* binary = std::getenv("TYNDALL_BINARY");
    if (binary == nullptr) GTEST_SKIP() << "TYNDALL_BINARY is not set";
    binary_ = binary;
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    scratch_ = name;
    folder_ = scratch_ / "work";
    fs::create_directory(folder_);
    std::ofstream(folder_ / "scene.json") << R"({
      "tyndall": 1,
      "medium": {"components": [{"field": {"type": "homogeneous"}, "extinction": 2, "albedo": [0.9, 0.9, 0.9]}]},
      "lights": [{"type": "point", "position": [1.5, 1.8, -0.5], "power": [100, 100, 100]}],
      "camera": {"resolution": [16, 16]},
      "photons": {"count": 1000, "illumination": {"resolution": 8}},
      "gather": {"samples": 1}
    })";
    exr_ = run({"--version"}).out.find(".exr") != std::string::npos;
    picture_ = exr_ ? "scene.exr" : "scene.pfm";
  }
  void TearDown() override {
    if (!scratch_.empty()) fs::remove_all(scratch_);
  }

  /// Starts the executable in folder_; its streams go to files beside folder_.
  pid_t start(std::vector<std::string> arguments, const char* out = nullptr) const {
    arguments.insert(arguments.begin(), binary_);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string out_path = out != nullptr ? out : (scratch_ / "out").string();
    const std::string err_path = scratch_ / "err";
    fs::remove(err_path);  // messages of the last command
    const pid_t child = ::fork();
    if (child != 0) return child;
    const auto send = [](const std::string& path, int stream) {
      ::dup2(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), stream);
    };
    send(out_path, STDOUT_FILENO);
    send(err_path, STDERR_FILENO);
    std::signal(SIGINT, SIG_DFL);  // a shell may have started the test in the background
    if (::chdir(folder_.c_str()) == 0) ::execv(argv[0], argv.data());
    ::_exit(127);
  }

  /// Time limit: longer than a busy machine needs, far shorter than the stopped renders.
  Outcome wait(pid_t child) const {
    const auto end = Clock::now() + 60s;
    int status = 0;
    while (::waitpid(child, &status, WNOHANG) == 0) {
      if (Clock::now() > end) {
        ADD_FAILURE() << "still running";
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        return {};
      }
      std::this_thread::sleep_for(2ms);
    }
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(scratch_ / "out"),
            contents(scratch_ / "err")};
  }

  Outcome run(const std::vector<std::string>& arguments, const char* out = nullptr) const {
    return wait(start(arguments, out));
  }

  /// Expects that the command fails with `code` and one line that contains `text`, prints nothing
  /// and leaves no file.
  void expect_error(const std::vector<std::string>& arguments, int code, const std::string& text) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const auto before = names();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(count_lines(outcome.err), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
    EXPECT_EQ(names(), before);
  }

  /// \return the names of the files in folder_.
  std::set<std::string> names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.insert(entry.path().filename());
    return names;
  }

  /// Starts a render that would take hours, and waits until its outputs are open and its work has
  /// begun.
  pid_t start_long_render(const std::string& output) const {
    const pid_t child = start(
        {"render", "scene.json", "-o", output, "--photons", "100000000000", "--progress", "plain"});
    for (int i = 0; i < 5000 && contents(scratch_ / "err").find("photons  ") == std::string::npos;
         ++i)
      std::this_thread::sleep_for(2ms);
    return child;
  }

  std::string binary_, picture_;
  fs::path scratch_, folder_;
  bool exr_ = false;
};

// ---- Streams and command lines

TEST_F(CliTest, PrintsWhatItIsAskedForOnStandardOutput) {
  for (const char* what : {"--version", "--help", "help", "schema", "defaults"}) {
    const Outcome outcome = run({what});
    EXPECT_EQ(outcome.code, 0) << what;
    EXPECT_NE(outcome.out, "") << what;
    EXPECT_EQ(outcome.err, "") << what;
  }
  EXPECT_EQ(run({"--version"}).out.substr(0, 8), "tyndall ");
  EXPECT_EQ(run({"--help"}).out.substr(0, 9), "Examples:");
  const Outcome help = run({"help", "render"});
  EXPECT_NE(help.out.find("--print-hash"), std::string::npos);
  EXPECT_EQ(help.out, run({"render", "--help"}).out);
}

// Libraries for images, volumes and MPI depend on hundreds of others.
TEST_F(CliTest, StartsWithoutTheLibrariesThatFewRunsNeed) {
  const std::string log = scratch_ / "loader";
  ::setenv("LD_DEBUG", "libs", 1);
  ::setenv("LD_DEBUG_OUTPUT", log.c_str(), 1);
  const pid_t child = start({"--version"});
  ::unsetenv("LD_DEBUG");
  ::unsetenv("LD_DEBUG_OUTPUT");
  EXPECT_EQ(wait(child).code, 0);
  const std::string loaded = contents(log + "." + std::to_string(child));
  if (loaded.find("find library=") == std::string::npos)
    GTEST_SKIP() << "the loader does not list the libraries";
  for (const char* library : {"libOpenImageIO", "libopenvdb", "libmpi"})
    EXPECT_EQ(loaded.find(std::string("find library=") + library), std::string::npos) << library;
}

TEST_F(CliTest, FailsWhereStandardOutputIsFull) {
  const Outcome outcome = run({"schema"}, "/dev/full");
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.err.find("No space left"), std::string::npos) << outcome.err;
}

TEST_F(CliTest, RefusesWrongCommandLines) {
  expect_error({}, 2, "tyndall help");
  expect_error({"rendre", "scene.json"}, 2, "rendre");
  expect_error({"render"}, 2, "SCENE");
  expect_error({"render", "scene.json", "--colour"}, 2, "--colour");
  expect_error({"render", "scene.json", "--photons", "many"}, 2,
               "an integer in [1, 1e+11], got 'many'");
  expect_error({"render", "scene.json", "--photons", "1.5"}, 2,
               "an integer in [1, 1e+11], got '1.5'");
  expect_error({"render", "scene.json", "--samples", "1e400"}, 2, "in [1, 1e+06], got '1e400'");
  for (const std::string wrong : {"-1", "18446744073709551616", "2e19", "0.5", "nan", "7 ", "x"}) {
    const std::string range = "expected an integer in [0, 18446744073709551615], got '";
    expect_error({"render", "scene.json", "-s", wrong}, 2, range + wrong + "'");
    expect_error({"render", "scene.json", "--batch", wrong}, 2, range + wrong + "'");
  }
  for (const std::string wrong : {"-1", "4097", "4294967297", "18446744073709551617", "many"}) {
    const std::string expected = "--threads: expected an integer in [0, 4096], got '";
    expect_error({"render", "scene.json", "-t", wrong}, 2, expected + wrong + "'");
  }
  expect_error({"render", "scene.json", "--progress", "dots"}, 2, "plain");
  expect_error({"render", "scene.json", "--device", "gpu"}, 2, "cuda:N");
  expect_error({"render", "scene.json", "-o", "picture.tiff"}, 2, ".pfm");
  expect_error({"render", "scene.json", "-o", "picture"}, 2, ".pfm");
  expect_error({"render", "scene.json", "-o", "a.pfm", "-o", "./a.pfm"}, 2, "twice");
  expect_error({"render", "scene.json", "--report", "scene.json"}, 2, "scene itself");
}

TEST_F(CliTest, ReplacesNoGridThatTheSceneReads) {
  const float densities[8] = {1, 1, 1, 1, 1, 1, 1, 1};
  fs::create_directory(folder_ / "grids");
  std::ofstream(folder_ / "grids/a.pfm", std::ios::binary)
      .write(reinterpret_cast<const char*>(densities), sizeof densities);
  fs::create_symlink("grids/a.pfm", folder_ / "link.pfm");
  const std::string grid =
      R"(medium.components[0].field={"type": "grid", "size": [2, 2, 2], "file": "grids/a.pfm"})";
  for (const char* output : {"grids/a.pfm", "./grids/../grids/a.pfm", "link.pfm"}) {
    expect_error({"render", "scene.json", "-D", grid, "-o", output}, 2, "read by the scene");
    expect_error({"render", "scene.json", "-D", grid, "--report", output}, 2, "read by the scene");
  }
  EXPECT_EQ(fs::file_size(folder_ / "grids/a.pfm"), sizeof densities);
  EXPECT_EQ(run({"render", "scene.json", "-D", grid, "-o", "b.pfm"}).code, 0);
}

TEST_F(CliTest, ConvertsScenes) {
  const std::string sphere = R"(medium.components[0].field={"type": "sphere"})";
  const Outcome outcome = run({"convert", "scene.json", "-D", sphere, "-o", "mitsuba.py"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "written  mitsuba.vol\nwritten  mitsuba.py\n");
  EXPECT_NE(contents(folder_ / "mitsuba.py").find("mitsuba.vol"), std::string::npos);
  EXPECT_EQ(fs::file_size(folder_ / "mitsuba.vol"), 48u + 4u * 256 * 256 * 256);
  EXPECT_EQ(run({"convert", "scene.json", "-D", sphere, "--voxels", "2e1", "-o", "a.py"}).code, 0);
  EXPECT_EQ(fs::file_size(folder_ / "a.vol"), 48u + 4u * 20 * 20 * 20);
  EXPECT_EQ(run({"convert", "scene.json", "-o", "a.pbrt"}).code, 0);
  expect_error({"convert", "scene.json"}, 2, "--output");
  expect_error({"convert", "scene.json", "-o", "none/a.py"}, 5, "none/a.py");

  // The grid beside the output must not be the one that the scene reads.
  const std::string density(32, '\x3f');  // 0.75 in every voxel
  std::ofstream(folder_ / "b.vol", std::ios::binary) << density;
  const std::string grid =
      R"(medium.components[0].field={"type": "grid", "size": [2, 2, 2], "file": "b.vol"})";
  expect_error({"convert", "scene.json", "-D", grid, "-o", "b.py"}, 2, "read by the scene");
  EXPECT_EQ(contents(folder_ / "b.vol"), density);
  EXPECT_FALSE(fs::exists(folder_ / "b.py"));
}

// ---- Renders

TEST_F(CliTest, FindsBadInputAndOutputBeforeItRenders) {
  const std::string hours = "100000000000";  // photons: far more than the time limit allows
  expect_error({"render", "none.json", "--photons", hours}, 4, "none.json");
  expect_error({"render", "scene.json", "--photons", "0"}, 2,
               "--photons: expected an integer in [1, 1e+11], got '0'");
  expect_error({"render", "scene.json", "--photons", hours, "-o", "none/a.pfm"}, 5, "none/a.pfm");
  fs::create_directory(folder_ / "folder.pfm");
  expect_error({"render", "scene.json", "--photons", hours, "-o", "folder.pfm"}, 5, "folder");
  expect_error({"render", "scene.json", "--photons", hours, "--report", "none/r.json"}, 5, "none");
  expect_error({"validate", "none.json"}, 4, "none.json");
}

TEST_F(CliTest, ValidatesScenes) {
  const Outcome outcome = run({"validate", "scene.json", "-D", "camera.fov=30"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "scene.json: valid\n");
  EXPECT_EQ(run({"validate", "scene.json", "-D", "camera.fov=-30"}).code, 3);
}

TEST_F(CliTest, RendersAndKeepsItsStreamsApart) {
  const Outcome outcome = run({"render", "scene.json", "--print-hash", "--report", "report.json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto hash = [&](std::size_t begin) {
    const std::string digits = outcome.out.substr(begin, 16);
    return digits.find_first_not_of("0123456789abcdef") == std::string::npos ? "HASH" : digits;
  };
  ASSERT_EQ(outcome.out.size(), 49u) << outcome.out;
  EXPECT_EQ(outcome.out.substr(0, 8) + hash(8) + outcome.out.substr(24, 8) + hash(32) + "\n",
            "tallies HASH pixels HASH\n");
  EXPECT_NE(outcome.err.find("the account closes"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("0 violations; one look-up in 256 is audited"), std::string::npos);
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos) << "a bar without a terminal";
  EXPECT_EQ(names(), (std::set<std::string>{"report.json", picture_, "scene.json"}));
  const std::string report = contents(folder_ / "report.json");
  EXPECT_NE(report.find(outcome.out.substr(8, 16)), std::string::npos) << report;
}

TEST_F(CliTest, AuditsNoBoundsWhereTheSamplerUsesNone) {
  const Outcome outcome = run({"render", "scene.json", "-D", "sampler=ray_marching"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("bounds   not used"), std::string::npos) << outcome.err;
}

/// The three numbers after `key` in JSON.
std::vector<double> rgb(const std::string& json, const std::string& key) {
  std::vector<double> values(3);
  const std::size_t at = json.find("\"" + key + "\": [");
  if (at == std::string::npos) return {};
  std::istringstream numbers(json.substr(json.find('[', at) + 1));
  char comma;
  numbers >> values[0] >> comma >> values[1] >> comma >> values[2];
  return values;
}

TEST_F(CliTest, DetectorsAccountForAllPower) {
  ASSERT_EQ(run({"render", "scene.json", "-o", "a.pfm", "--detectors", "d.json", "-D",
                 "detectors.absorbed=1", "-D", "detectors.flux=[1,1]"})
                .code,
            0);
  const std::string json = contents(folder_ / "d.json");
  const auto shot = rgb(json, "shot"), absorbed = rgb(json, "absorbed");
  ASSERT_EQ(shot.size(), 3u) << json;
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (const char* term : {"missed", "escaped", "absorbed", "roulette", "stalled"})
      sum += rgb(json, term).at(c);
    EXPECT_NEAR(sum, shot[c], 1e-12 * shot[c]) << json;
    EXPECT_GT(absorbed[c], 0.0);
    EXPECT_NE(rgb(json, "roulette").at(c), 0.0) << "0 only on average";
  }
  const std::size_t voxel = json.find("\"size\": [1, 1, 1]");
  ASSERT_NE(voxel, std::string::npos) << json;
  std::string inner = json.substr(json.find("[[", voxel) + 1);
  EXPECT_EQ(rgb("\"p\": " + inner, "p"), absorbed) << "the single voxel has all of it";
}

TEST_F(CliTest, PathsHaveNoUseForDetectors) {
  const Outcome outcome = run({"render", "scene.json", "-o", "a.pfm", "-D", "integrator=path", "-D",
                               "detectors.flux=[2,2]", "-D", "detectors.scatterings.bins=4"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::size_t first = outcome.err.find("the integrator path shoots none");
  EXPECT_NE(first, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("detectors", first), std::string::npos) << "one line\n" << outcome.err;
  EXPECT_EQ(names(), (std::set<std::string>{"a.pfm", "scene.json"}));
  const Outcome refused = run({"render", "scene.json", "-o", "b.pfm", "-D", "integrator=path", "-D",
                               "detectors.flux=[2,2]", "--detectors", "d.json"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--detectors d.json: they count photons"), std::string::npos)
      << refused.err;
}

TEST_F(CliTest, WritesTheSameBytesForTheSameSeed) {
  std::vector<std::string> arguments{"render", "scene.json", "-o", "1.pfm", "--photons", "2e3"};
  if (exr_) arguments.insert(arguments.end(), {"-o", "1.exr"});
  ASSERT_EQ(run(arguments).code, 0);
  for (std::string& argument : arguments)
    if (argument.substr(0, 2) == "1.") argument[0] = '2';
  arguments.insert(arguments.end(), {"-t", "3", "--batch", "77"});
  ASSERT_EQ(run(arguments).code, 0);
  EXPECT_TRUE(contents(folder_ / "1.pfm") == contents(folder_ / "2.pfm"));
  EXPECT_TRUE(contents(folder_ / "1.exr") == contents(folder_ / "2.exr"));
  ASSERT_EQ(run({"render", "scene.json", "-o", "3.pfm", "--photons", "2000", "-s", "9"}).code, 0);
  EXPECT_TRUE(contents(folder_ / "1.pfm") != contents(folder_ / "3.pfm"));
}

TEST_F(CliTest, TakesCountsUpToTheirLimits) {
  const auto tallies = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"render", "scene.json", "-o", "a.pfm", "--print-hash"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_EQ(tallies({"-s", "1e17"}), tallies({"-D", "seed=100000000000000000"}));
  EXPECT_EQ(tallies({"-s", "18446744073709551615", "-t", "4e0", "--batch", "18446744073709551615"}),
            tallies({"-D", "seed=18446744073709551615"}));
}

TEST_F(CliTest, WritesPreviews) {
  if (run({"--version"}).out.find(".png") == std::string::npos)
    GTEST_SKIP() << "this build has no zlib";
  const Outcome outcome = run({"render", "scene.json", "-o", "a.png"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string first = contents(folder_ / "a.png");
  EXPECT_EQ(first.substr(1, 3), "PNG");
  ASSERT_EQ(run({"render", "scene.json", "-o", "a.png"}).code, 0);
  EXPECT_TRUE(contents(folder_ / "a.png") == first);
}

TEST_F(CliTest, ReportsProgressInLinesWhereAskedTo) {
  const Outcome outcome = run({"render", "scene.json", "--progress", "plain"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("photons  100 %"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos);
}

TEST_F(CliTest, KeepsTheOtherOutputsWhereOneFails) {
  const Outcome outcome = run({"render", "scene.json", "--report", "/dev/full"});
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.err.find("/dev/full"), std::string::npos) << outcome.err;
  EXPECT_EQ(names(), (std::set<std::string>{picture_, "scene.json"}));
}

// ---- Signals

TEST_F(CliTest, StopsAtASignalAndLeavesTheOldFile) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    std::ofstream(folder_ / "a.pfm") << "old";
    const pid_t child = start_long_render("a.pfm");
    EXPECT_EQ(names().size(), 3u) << "the temporary is open";
    ::kill(child, signal);
    EXPECT_EQ(wait(child).code, code);
    EXPECT_EQ(contents(folder_ / "a.pfm"), "old");
    EXPECT_EQ(names(), (std::set<std::string>{"a.pfm", "scene.json"}));
  }
}

TEST_F(CliTest, StopsInTheMidstOfAPhotonThatWalksForMinutes) {
  const pid_t child =
      start({"render", "scene.json", "-o", "a.pfm", "--progress", "plain", "-D",
             R"(medium.components[0]={"field":{"type":"homogeneous"},"extinction":1e6,"albedo":1})",
             "-D", "lights[0].position=[0.5,0.5,0.5]"});
  for (int i = 0; i < 5000 && contents(scratch_ / "err").find("photons  ") == std::string::npos;
       ++i)
    std::this_thread::sleep_for(2ms);
  ::kill(child, SIGINT);
  const Outcome outcome = wait(child);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_NE(outcome.err.find("stopped by a signal"), std::string::npos) << outcome.err;
  EXPECT_EQ(names(), std::set<std::string>{"scene.json"});
}

TEST_F(CliTest, LeavesAtOnceAtTheSecondSignal) {
  const pid_t child = start_long_render("a.pfm");
  ::kill(child, SIGTERM);
  ::kill(child, SIGINT);
  const int code = wait(child).code;
  EXPECT_TRUE(code == 130 || code == 143) << code;
  EXPECT_EQ(names(), std::set<std::string>{"scene.json"});
}

// ---- Checkpoints, limits, parts

class ResumeTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    if (IsSkipped()) return;
    if (run({"merge", "a.tyn", "-o", "b.tyn"}).err.find("TYNDALL_ZSTD is off") != std::string::npos)
      GTEST_SKIP() << "this build has no checkpoints";
  }
  /// The render takes a few seconds.
  static std::vector<std::string> long_render(std::vector<std::string> more,
                                              const std::string& photons = "2e6",
                                              const std::string& samples = "512") {
    more.insert(more.begin(),
                {"render", "scene.json", "-o", "a.pfm", "--photons", photons, "--samples", samples,
                 "-D", "camera.resolution=[128,128]", "--print-hash", "--progress", "plain"});
    return more;
  }
  void wait_for(const std::string& said) const {
    for (int i = 0; i < 15000 && contents(scratch_ / "err").find(said) == std::string::npos; ++i)
      std::this_thread::sleep_for(2ms);
  }
};

TEST_F(ResumeTest, GoesOnAfterASignalToTheSameEnd) {
  const std::string whole = run(long_render({})).out;
  ASSERT_NE(whole, "");
  const auto arguments =
      long_render({"--checkpoint", "c.tyn", "--checkpoint-every", "0", "--resume"});
  for (const char* pass : {"photons", "pixels"}) {
    const pid_t child = start(arguments);
    wait_for(pass);
    std::this_thread::sleep_for(100ms);
    ::kill(child, SIGINT);
    const Outcome stopped = wait(child);
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_NE(stopped.err.find("--resume goes on"), std::string::npos) << stopped.err;
    EXPECT_EQ(names(), (std::set<std::string>{"a.pfm", "c.tyn", "scene.json"}));
  }
  const Outcome again = run({"render", "scene.json", "--checkpoint", "c.tyn"});
  EXPECT_EQ(again.code, 2);
  EXPECT_NE(again.err.find("c.tyn: is there already; add --resume"), std::string::npos)
      << again.err;
  const Outcome end = run(arguments);
  EXPECT_EQ(end.code, 0) << end.err;
  EXPECT_NE(end.err.find("resume   c.tyn: "), std::string::npos) << end.err;
  EXPECT_EQ(end.out, whole);
  EXPECT_EQ(names(), (std::set<std::string>{"a.pfm", "scene.json"})) << "no longer needed";
}

TEST_F(ResumeTest, GoesOnAfterSigkill) {
  const std::string whole = run(long_render({})).out;
  const auto arguments =
      long_render({"--checkpoint", "c.tyn", "--checkpoint-every", "0", "--resume"});
  for (const auto delay : {150ms, 400ms, 700ms}) {
    const pid_t child = start(arguments);
    wait_for("photons");
    std::this_thread::sleep_for(delay);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  const Outcome end = run(arguments);
  EXPECT_EQ(end.out, whole);
  EXPECT_TRUE(std::regex_search(end.err, std::regex("resume   c.tyn: [1-9][0-9]* of"))) << end.err;
}

TEST_F(ResumeTest, SaysWhichCheckpointCannotBe) {
  const std::string long_name(300, 'a');
  expect_error({"render", "scene.json", "--checkpoint", long_name + ".tyn"}, 5,
               "File name too long");
  expect_error({"render", "scene.json", "--checkpoint", "no/c.tyn", "--resume"}, 5,
               "no/c.tyn: cannot be written");
}

TEST_F(ResumeTest, RefusesTheCheckpointOfAnotherScene) {
  ASSERT_EQ(run({"render", "scene.json", "-o", "c.tyn"}).code, 0);
  expect_error({"render", "scene.json", "-s", "2", "--checkpoint", "c.tyn", "--resume"}, 4,
               "c.tyn: cannot be merged with this render: its seed is 1, not 2");
  std::ofstream(folder_ / "c.tyn") << "no part at all";
  expect_error({"render", "scene.json", "--checkpoint", "c.tyn", "--resume"}, 4,
               "c.tyn: it is no part of a render");
  expect_error({"render", "scene.json", "--resume"}, 2, "--checkpoint FILE is missing");
  expect_error({"render", "scene.json", "-o", "d.tyn", "--checkpoint", "d.tyn"}, 2,
               "d.tyn: is asked for twice");
  expect_error({"render", "scene.json", "--checkpoint", "scene.json", "--resume"}, 2,
               "scene.json: is the scene itself");
}

TEST_F(ResumeTest, ShowsThePictureWhereAskedAndGoesOn) {
  const std::string whole = run(long_render({})).out;
  const std::string picture = contents(folder_ / "a.pfm");
  fs::remove(folder_ / "a.pfm");
  const pid_t child = start(long_render({}));
  wait_for("pixels");
  std::this_thread::sleep_for(300ms);
  ::kill(child, SIGUSR1);
  wait_for("written  a.pfm");
  const std::string so_far = contents(folder_ / "a.pfm");
  EXPECT_EQ(so_far.size(), picture.size());
  EXPECT_NE(so_far, picture);
  EXPECT_EQ(wait(child).out, whole);
  EXPECT_EQ(contents(folder_ / "a.pfm"), picture);
}

TEST_F(ResumeTest, PreviewsWhileItRenders) {
  const pid_t child = start(long_render({"--preview", "p.pfm", "--every", "0.05s"}));
  std::string early;
  for (int i = 0; i < 5000 && early.empty(); ++i) {
    early = contents(folder_ / "p.pfm");
    std::this_thread::sleep_for(2ms);
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.pfm") && !contents(folder_ / "a.pfm").empty())
      << "it was still rendering";
  EXPECT_EQ(wait(child).code, 0);
  const std::string whole = contents(folder_ / "a.pfm");
  EXPECT_EQ(early.size(), whole.size());
  EXPECT_NE(early, whole);
  EXPECT_EQ(contents(folder_ / "p.pfm"), whole) << "the last preview is the picture";
  expect_error({"render", "scene.json", "--every", "1s"}, 2, "--preview");
  fs::remove(folder_ / "p.pfm");  // photons alone give no picture
  const Outcome photons =
      run({"render", "scene.json", "--photon-range", "0:10", "-o", "l.tyn", "--preview", "p.pfm"});
  EXPECT_EQ(photons.code, 0) << photons.err;
  EXPECT_FALSE(fs::exists(folder_ / "p.pfm"));
}

TEST_F(ResumeTest, EndsAtALimitWithAPicture) {
  const Outcome limited =
      run(long_render({"--time-limit", "1s", "--report", "r.json"}, "1e9", "1e6"));
  EXPECT_EQ(limited.code, 0) << limited.err;
  EXPECT_NE(limited.err.find("stopped by --time-limit 1s; the output has photons 0:"),
            std::string::npos)
      << limited.err;
  EXPECT_NE(limited.err.find("limit    --time-limit 1s ended the render"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "a.pfm"));
  EXPECT_NE(contents(folder_ / "r.json").find("\"limit\": \"--time-limit 1s\""), std::string::npos);
  const Outcome quiet = run(long_render({"--noise", "0.5", "--report", "r.json"}, "2e6", "400"));
  EXPECT_EQ(quiet.code, 0) << quiet.err;
  const std::string report = contents(folder_ / "r.json");
  EXPECT_NE(report.find("\"complete\": false"), std::string::npos) << report;
  EXPECT_NE(report.find("\"limit\": \"--noise 0.5\""), std::string::npos) << report;
  EXPECT_NE(report.find("\"ranges.samples\": \"0:1, 50:51, 100:101"), std::string::npos) << report;
  const Outcome whole =
      run({"render", "scene.json", "-o", "a.pfm", "--report", "r.json", "--noise", "1e-9"});
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_NE(contents(folder_ / "r.json").find("\"limit\": null"), std::string::npos);
  const auto refuses = [&](const char* option, const char* value, const char* text) {
    expect_error({"render", "scene.json", option, value}, 2, text);
  };
  refuses("--time-limit", "soon", "expected a time above 0 such as 90s");
  refuses("--time-limit", "0s", "expected a time above 0 such as 90s");
  for (const char* noise : {"0", "nan", "1", "1e-400", "0.1x"})
    refuses("--noise", noise, "expected a number above 0 and below 1");
}

TEST_F(ResumeTest, AddsPartsUp) {
  const std::vector<std::string> scene{"render", "scene.json", "--samples", "9", "--print-hash"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), scene.begin(), scene.end());
    return more;
  };
  const std::string whole = run(with({"-o", "whole.pfm"})).out;
  ASSERT_EQ(run(with({"--sample-range", "0:4", "-o", "a.tyn"})).code, 0);
  ASSERT_EQ(run(with({"--sample-range", "4:9", "-o", "b.tyn"})).code, 0);
  EXPECT_EQ(run({"merge", "b.tyn", "a.tyn", "-o", "c.pfm", "--print-hash"}).out, whole);
  EXPECT_EQ(contents(folder_ / "c.pfm"), contents(folder_ / "whole.pfm"));

  ASSERT_EQ(run(with({"--photon-range", "0:333", "-o", "p.tyn"})).code, 0);
  ASSERT_EQ(run(with({"--photon-range", "333:1000", "-o", "q.tyn"})).code, 0);
  ASSERT_EQ(run({"merge", "p.tyn", "q.tyn", "-o", "light.tyn"}).code, 0);
  EXPECT_EQ(run(with({"--illumination", "light.tyn", "-o", "d.pfm"})).out, whole);
  EXPECT_NE(run({"info", "light.tyn"}).out.find("0:1000 of 1000"), std::string::npos);

  expect_error({"merge", "a.tyn", "a.tyn", "-o", "x.pfm"}, 4, "both have samples 0:");
  // The message names these two files, not the parts merged before.
  expect_error({"merge", "b.tyn", "a.tyn", "b.tyn", "-o", "x.pfm"}, 4,
               "b.tyn: cannot be merged with b.tyn: both have samples 4:9");
  expect_error({"merge", "p.tyn", "p.tyn", "-o", "x.tyn"}, 4,
               "p.tyn: cannot be merged with p.tyn: both have photons 0:333");
  expect_error({"merge", "a.tyn", "b.tyn", "-o", "a.tyn"}, 2, "a.tyn: is one of the parts");
  expect_error(with({"-D", "integrator=path", "--photon-range", "0:9", "-o", "x.tyn"}), 2,
               "paths (integrator \"path\") shoot no photons");
  expect_error({"merge", "a.tyn", "-o", "x.pfm"}, 4, "lacks photons");
  expect_error(with({"--illumination", "p.tyn", "-o", "x.pfm"}), 4, "--allow-gaps");
  expect_error(with({"--photon-range", "0:9", "-o", "x.pfm"}), 2, "photons alone make no picture");
  expect_error(with({"--sample-range", "5:4", "-o", "x.tyn"}), 2, "expected A:B with A below B");
  expect_error(with({"--sample-range", "0:10", "-o", "x.tyn"}), 2, "the scene has 9");
  EXPECT_EQ(run({"merge", "a.tyn", "-o", "x.pfm", "--allow-gaps"}).code, 0);
  const Outcome gaps = run(with({"--illumination", "p.tyn", "--allow-gaps", "-o", "x.pfm"}));
  EXPECT_EQ(gaps.code, 0) << gaps.err;
  EXPECT_NE(gaps.err.find("p.tyn: lacks photons 333:1000"), std::string::npos) << gaps.err;
}

// ---- Devices

TEST_F(CliTest, HasNoCudaDeviceWhereThereIsNone) {
  const Outcome outcome = run({"render", "scene.json", "--device", "cuda:99"});
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(count_lines(outcome.err), 1u) << outcome.err;
}

TEST_F(CliTest, ListsDevicesAndTakesOne) {
  const Outcome outcome = run({"devices"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out.find("cpu      cpu, "), 0u) << outcome.out;
  EXPECT_NE(outcome.out.find("\ncuda"), std::string::npos) << outcome.out;
  const std::string by_cpu = run({"render", "scene.json", "--device", "cpu", "--print-hash"}).out;
  const Outcome taken = run({"render", "scene.json", "--device", "auto", "--print-hash"});
  EXPECT_EQ(taken.code, 0) << taken.err;
  EXPECT_EQ(taken.out, by_cpu);
}

// ---- Sequences

TEST_F(CliTest, FramesAreWhatTheyAreAlone) {
  // If only the camera moves, photons are shot once; if the seed changes, for each frame.
  const Outcome moving = run({"render", "scene.json", "--frames", "1:3", "-D",
                              "camera.fov={frame}5", "-o", "f.##.pfm", "--print-hash"});
  ASSERT_EQ(moving.code, 0) << moving.err;
  EXPECT_NE(moving.err.find("light    of frame 1"), std::string::npos) << moving.err;
  const Outcome seeds = run({"render", "scene.json", "--frames", "1:5:2", "-D", "seed={frame}",
                             "-o", "s.###.pfm", "--print-hash"});
  ASSERT_EQ(seeds.code, 0) << seeds.err;
  EXPECT_EQ(seeds.err.find("light    of frame"), std::string::npos) << seeds.err;
  for (const char* name :
       {"f.01.pfm", "f.02.pfm", "f.03.pfm", "s.001.pfm", "s.003.pfm", "s.005.pfm"})
    EXPECT_TRUE(names().contains(name)) << name;
  const auto alone = [&](const std::string& define) {
    return run({"render", "scene.json", "-D", define, "-o", "x.pfm", "--print-hash"}).out;
  };
  EXPECT_NE(moving.out.find("frame 3 " + alone("camera.fov=35")), std::string::npos) << moving.out;
  EXPECT_NE(seeds.out.find("frame 5 " + alone("seed=5")), std::string::npos) << seeds.out;
}

TEST_F(CliTest, EachFrameSaysWhatIsWrongWithIt) {
  const Outcome said =
      run({"render", "scene.json", "--frames", "1:3", "-D", "marching_step={t}", "-o", "f.##.pfm"});
  ASSERT_EQ(said.code, 0) << said.err;
  const std::size_t first = said.err.find("marching_step: "), frame = said.err.find("frame    2 ");
  ASSERT_NE(first, std::string::npos) << said.err;
  EXPECT_GT(first, frame) << "nothing is wrong with frame 1\n" << said.err;
  EXPECT_EQ(
      run({"render", "scene.json", "--frames", "1:2", "--turntable", "nan", "-o", "f.##.pfm"}).code,
      2);
  EXPECT_EQ(run({"render", "scene.json", "--frames", "1:2", "--allow-gaps", "-o", "f.##.pfm"}).code,
            2);
}

TEST_F(CliTest, ATurntableTurnsTheCamera) {
  const Outcome turned = run({"render", "scene.json", "--frames", "0:3", "--turntable", "360", "-D",
                              "camera.position=[0.5,0.5,-2]", "-D", "camera.look_at=[0.5,0.5,0.5]",
                              "-o", "f.##.pfm", "--print-hash"});
  ASSERT_EQ(turned.code, 0) << turned.err;
  const Outcome half = run({"render", "scene.json", "-D", "camera.position=[0.5,0.5,3]", "-D",
                            "camera.look_at=[0.5,0.5,0.5]", "-o", "x.pfm", "--print-hash"});
  // Equal except for the rounding of the rotated position.
  const std::string a = contents(folder_ / "f.02.pfm"), b = contents(folder_ / "x.pfm");
  ASSERT_EQ(a.size(), b.size());
  const std::string first = contents(folder_ / "f.00.pfm");
  EXPECT_NE(a, first);
  const auto values = [](const std::string& file) {
    std::vector<float> v(16 * 16 * 3);
    std::memcpy(v.data(), file.data() + file.size() - v.size() * sizeof(float),
                v.size() * sizeof(float));
    return v;
  };
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < values(a).size(); ++i) {
    difference += std::abs(values(a)[i] - values(b)[i]);
    sum += values(b)[i];
  }
  EXPECT_LT(difference, 0.02 * sum) << half.out << turned.out;
}

TEST_F(CliTest, ASequenceGoesOnWhereItWasStopped) {
  const std::vector<std::string> line{
      "render",      "scene.json", "--frames", "1:2", "-o", exr_ ? "f.####.exr" : "f.####.pfm",
      "--print-hash"};
  const Outcome first = run(line);
  ASSERT_EQ(first.code, 0) << first.err;
  fs::remove(folder_ / (exr_ ? "f.0002.exr" : "f.0002.pfm"));
  const Outcome again = run(line);
  EXPECT_EQ(again.code, 0);
  EXPECT_NE(again.err.find("frame    1 (1 of 2): is there already"), std::string::npos)
      << again.err;
  EXPECT_EQ(again.out, first.out.substr(first.out.find("frame 2")));
  if (exr_) {  // the header has the hash of the scene
    std::vector<std::string> other = line;
    other.insert(other.end(), {"-s", "9"});
    expect_error(other, 2, "f.0001.exr: is there already, of another scene");
    other[5] = "F.####.EXR";
    ASSERT_EQ(run({"render", "scene.json", "--frames", "1:2", "-o", other[5]}).code, 0);
    expect_error(other, 2, "F.0001.EXR: is there already, of another scene");
    std::ofstream(folder_ / "F.0001.EXR") << "nothing";
    expect_error(other, 4, "remove it");
  }
  std::vector<std::string> endless = line;
  endless[5] = "g.####.pfm";
  endless.insert(endless.end(), {"--photons", "100000000000", "--progress", "plain"});
  const auto before = names();
  const pid_t child = start(endless);
  for (int i = 0; i < 5000 && contents(scratch_ / "err").find("photons  ") == std::string::npos;
       ++i)
    std::this_thread::sleep_for(2ms);
  ::kill(child, SIGINT);
  EXPECT_EQ(wait(child).code, 130);
  EXPECT_EQ(names(), before);  // an incomplete file does not count as a frame
}

/// A scene of a simulation, with files of the test or of write-volumes.
class SequenceTest : public CliTest {
 protected:
  static std::string raw(const char* file = "v##.raw") {
    return std::string(R"(medium.components[0].field={"type":"grid","size":[2,2,2],"file":")")
           + file + "\"}";
  }
  /// \param more keys of the field
  static std::string vdb(const std::string& file, const std::string& more = "") {
    return R"(medium.components[0].field={"type":"vdb","file":")" + file + "\"" + more + "}";
  }
  void write_raw(const std::string& name, float density) const {
    const std::vector<float> densities(8, density);
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(densities.data()), 8 * sizeof(float));
  }
  bool copy_volumes(const std::vector<std::string>& names) const {
    const char* from = std::getenv("TYNDALL_TEST_VOLUMES");
    if (from == nullptr || !fs::exists(from)) return false;
    for (const std::string& name : names) fs::copy_file(fs::path(from) / name, folder_ / name);
    return true;
  }
  /// \return the mean of all channels of a picture without a background; 0: an empty picture.
  double mean(const std::string& name) const {
    const std::string file = contents(folder_ / name);
    std::vector<float> v(16 * 16 * 3);
    if (file.size() < v.size() * sizeof(float)) return -1;
    std::memcpy(v.data(), file.data() + file.size() - v.size() * sizeof(float),
                v.size() * sizeof(float));
    double sum = 0;
    for (const float x : v) sum += double{x};
    return sum / static_cast<double>(v.size());
  }
  Outcome sequence(const std::string& frames, const std::vector<std::string>& defines,
                   const std::string& command = "render") const {
    std::vector<std::string> line{command, "scene.json", "--frames", frames};
    if (command == "render") line.insert(line.end(), {"-o", "f.##.pfm", "--print-hash"});
    for (const std::string& define : defines) line.insert(line.end(), {"-D", define});
    return run(line);
  }
  static bool says(const Outcome& outcome, const std::string& text) {
    return outcome.err.find(text) != std::string::npos;
  }
};

TEST_F(SequenceTest, RendersTheFramesThatCanBeReadAndListsTheOthers) {
  for (const char* name : {"v01.raw", "v04.raw", "v05.raw"}) write_raw(name, 1);
  std::ofstream(folder_ / "v03.raw") << "half writ";
  const Outcome outcome = sequence("1:5", {raw()});
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  for (const char* name : {"f.01.pfm", "f.04.pfm", "f.05.pfm"})
    EXPECT_GT(mean(name), 0.0) << name << outcome.err;
  EXPECT_FALSE(names().contains("f.02.pfm") || names().contains("f.03.pfm"));
  EXPECT_LT(outcome.err.find("1 of 5 frames lack a file, such as v02.raw: 2"),
            outcome.err.find("frame    1 "))
      << "before the first frame\n"
      << outcome.err;
  const std::size_t end = outcome.err.find("tyndall: 2 of 5 frames could not be read: 2-3");
  ASSERT_NE(end, std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("v02.raw: No such file", end), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("v03.raw: expected 4 x 2 x 2 x 2 bytes, got 9", end),
            std::string::npos)
      << outcome.err;
  // A second run resumes the sequence: pictures stay, even if their inputs are gone.
  write_raw("v02.raw", 1), write_raw("v03.raw", 0.5f);
  fs::remove(folder_ / "v04.raw");
  const Outcome again = sequence("1:5", {raw()});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(std::count(again.out.begin(), again.out.end(), '\n'), 2) << again.out;
  EXPECT_GT(mean("f.03.pfm"), 0.0);
}

TEST_F(SequenceTest, TheFirstAndTheLastFrameMayBeThoseThatCannotBeRead) {
  write_raw("v02.raw", 1);
  const Outcome outcome = sequence("1:3", {raw()});
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_EQ(names(), (std::set<std::string>{"f.02.pfm", "scene.json", "v02.raw"}));
  EXPECT_TRUE(says(outcome, "2 of 3 frames could not be read: 1, 3")) << outcome.err;
}

TEST_F(SequenceTest, WhatNoFrameCanDoWithoutIsSaidAtOnce) {
  write_raw("v01.raw", 1), write_raw("v02.raw", 1);
  const auto refuses = [&](const std::vector<std::string>& defines, int code,
                           const std::string& text) {
    const auto before = names();
    const Outcome outcome = sequence("1:2", defines);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_TRUE(says(outcome, text)) << outcome.err;
    EXPECT_FALSE(says(outcome, "frame    1")) << outcome.err;
    EXPECT_EQ(names(), before);
  };
  refuses({raw("smoke##.raw")}, 4, "smoke01.raw: no such file; every frame lacks one");
  refuses({raw("v.raw")}, 4, "v.raw: No such file");
  refuses({raw(), R"(lights[0]={"type":"environment","image":"sky.hdr"})"}, 4, "sky.hdr: no such");
  refuses({raw(), "camera.fov={frame}00"}, 3, "camera.fov: expected degrees in (0, 180), got 200");
}

TEST_F(SequenceTest, OneSceneThatCannotBeDoesNotEndTheOthers) {
  write_raw("v01.raw", 1), write_raw("v02.raw", 1e9f), write_raw("v03.raw", 1);
  const Outcome outcome = sequence("1:3", {raw()});
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_TRUE(says(outcome, "1 of 3 frames could not be read: 2")) << outcome.err;
  EXPECT_TRUE(says(outcome, "too dense for single precision")) << outcome.err;
  EXPECT_GT(mean("f.03.pfm"), 0.0);
}

TEST_F(SequenceTest, AFrameWithoutVoxelsIsAFrameWithoutMatter) {
  if (!copy_volumes({"sim.01.vdb", "sim.02.vdb", "sim.03.vdb", "late.01.vdb", "late.02.vdb"}))
    GTEST_SKIP() << "built without OpenVDB";
  const std::string thin = "medium.components[0].extinction=0.05";
  const std::string box = R"(medium.box={"min":[-20,-20,-20],"max":[20,60,20]})";
  const std::string look =
      R"(camera={"position":[0,0,-60],"look_at":[0,0,0],"resolution":[16,16]})";
  const Outcome middle = sequence("1:3", {vdb("sim.##.vdb"), box, look, thin});
  EXPECT_EQ(middle.code, 0) << middle.err;
  EXPECT_GT(mean("f.01.pfm"), 0.0);
  EXPECT_EQ(mean("f.02.pfm"), 0.0);
  EXPECT_GT(mean("f.03.pfm"), 0.0);
  EXPECT_TRUE(says(middle, "sim.02.vdb: no active voxels: empty in this frame")) << middle.err;
  for (const char* name : {"f.01.pfm", "f.02.pfm", "f.03.pfm"}) fs::remove(folder_ / name);

  // The empty first frame alone, without a box: the picture is the background.
  for (const char* frames : {"1:2", "1"}) {
    const Outcome first = sequence(frames, {vdb("late.##.vdb"), look, "background=1"});
    EXPECT_EQ(first.code, 0) << first.err;
    EXPECT_EQ(mean("f.01.pfm"), 1.0) << first.err;
    fs::remove(folder_ / "f.01.pfm");
  }
  EXPECT_GT(mean("f.02.pfm"), 0.0);
  // In a still an empty volume is an error: a single named file should not be empty.
  expect_error({"render", "scene.json", "-D", vdb("late.01.vdb")}, 4, "no active voxels");
  EXPECT_EQ(sequence("1:2", {vdb("late.01.vdb")}).code, 4)
      << "an empty file of all frames is an error, too";
}

TEST_F(SequenceTest, AGridThatOneFrameLacksIsEmptyThere) {
  if (!copy_volumes({"sim.01.vdb", "sim.02.vdb", "sim.03.vdb", "sim.04.vdb", "surface.01.vdb"}))
    GTEST_SKIP() << "built without OpenVDB";
  const std::string look =
      R"(camera={"position":[0,0,-60],"look_at":[0,0,0],"resolution":[16,16]})";
  const std::string glow =
      R"(medium.components[0].emission={"type":"blackbody","temperature":{"type":"vdb","file":"sim.##.vdb",)"
      R"("remap":{"scale":3000}}})";
  const Outcome outcome = sequence(
      "1:4", {vdb("sim.##.vdb"), glow, look, "lights=[]", "medium.components[0].albedo=0.5"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_GT(mean("f.01.pfm"), 0.0);
  EXPECT_EQ(mean("f.03.pfm"), 0.0) << "without a temperature it does not glow";
  EXPECT_EQ(mean("f.04.pfm"), 0.0);
  const std::string lacks = "lacks this grid, which other frames have: taken as empty";
  EXPECT_TRUE(says(outcome, "emission.temperature.file: sim.03.vdb: " + lacks)) << outcome.err;
  EXPECT_TRUE(says(outcome, "field.file: sim.04.vdb: " + lacks)) << outcome.err;
  // A grid that no frame has is an error.
  const Outcome none = sequence("1:4", {vdb("sim.##.vdb", R"(,"grid":"desnity")"), look});
  EXPECT_EQ(none.code, 4);
  EXPECT_TRUE(says(none, R"(it has no grid "desnity"; its grids: "density")")) << none.err;
  EXPECT_FALSE(says(none, "frame    2 ")) << none.err;
  // A surface without faces has no inside, independent of its background.
  fs::remove(folder_ / "f.01.pfm");
  const Outcome surface = sequence("1", {vdb("surface.##.vdb"), look, "background=1"});
  EXPECT_EQ(surface.code, 0) << surface.err;
  EXPECT_EQ(mean("f.01.pfm"), 1.0);
}

TEST_F(SequenceTest, IsFittedOnceForAllFrames) {
  if (!copy_volumes({"late.01.vdb", "late.02.vdb", "late.03.vdb"}))
    GTEST_SKIP() << "built without OpenVDB";
  const std::string field = vdb("late.##.vdb", R"(,"fit":"unit_cube")");
  const Outcome outcome = sequence("1:3", {field});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string fit = "fit      medium.components[0].field.file: in all frames as in ";
  EXPECT_TRUE(says(outcome, fit + "late.02.vdb")) << outcome.err;
  EXPECT_EQ(outcome.err.find(fit), outcome.err.rfind(fit)) << "once\n" << outcome.err;
  // The first non-empty frame is placed as in a still; the other frames are placed in the same way.
  const auto hash_of = [](const std::string& out, int frame) {
    const std::size_t at = out.find("frame " + std::to_string(frame));
    return out.substr(out.find("tallies", at), 49);
  };
  const std::string still =
      run({"render", "scene.json", "-D", vdb("late.02.vdb", R"(,"fit":"unit_cube")"), "-o", "x.pfm",
           "--print-hash"})
          .out;
  EXPECT_EQ(hash_of(outcome.out, 2), still);
  fs::remove(folder_ / "f.03.pfm");
  const Outcome by_itself = sequence("3", {field});
  EXPECT_NE(by_itself.out, outcome.out.substr(outcome.out.find("frame 3")));
  // A box of the scene cuts what grows beyond it, with a warning.
  const Outcome cut =
      sequence("2:3", {field, R"(medium.box={"min":[0,0,0],"max":[1,1,1]})"}, "validate");
  EXPECT_EQ(cut.code, 0) << cut.err;
  EXPECT_TRUE(says(cut, "reaches beyond medium.box")) << cut.err;
}

TEST_F(SequenceTest, ValidatesEveryFrame) {
  for (const char* name : {"v01.raw", "v03.raw"}) write_raw(name, 1);
  const Outcome good = sequence("1:3:2", {raw()}, "validate");
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_EQ(good.out, "scene.json: valid in 2 frames\n");
  const Outcome bad = sequence("1:4", {raw()}, "validate");
  EXPECT_EQ(bad.code, 4) << bad.err;
  EXPECT_EQ(bad.out, "");
  EXPECT_TRUE(says(bad, "2 of 4 frames could not be read: 2, 4")) << bad.err;
}

TEST_F(SequenceTest, GrainMovesWithoutShootingTheLightAnew) {
  const Outcome moving = sequence("1:3", {"gather.seed={frame}"});
  ASSERT_EQ(moving.code, 0) << moving.err;
  EXPECT_TRUE(says(moving, "frame    3 (3 of 3)\nlight    of frame 1")) << moving.err;
  EXPECT_NE(contents(folder_ / "f.01.pfm"), contents(folder_ / "f.02.pfm"));
  const Outcome alone =
      run({"render", "scene.json", "-D", "gather.seed=3", "-o", "x.pfm", "--print-hash"});
  EXPECT_NE(moving.out.find("frame 3 " + alone.out), std::string::npos) << moving.out;
}

TEST_F(CliTest, RefusesWrongSequences) {
  for (const std::string flag : {"--frames=-5:2", "--frames=-5", "--frames=1:-2"})
    expect_error({"render", "scene.json", flag, "-o", "f.##.pfm"}, 2, "frame numbers start at 0");
  expect_error({"render", "scene.json", "--frames", "-5:2", "-o", "f.##.pfm"}, 2,
               "frame numbers start at 0");
  for (const char* wrong : {"", "3:", "3:1", "1:2:0", "a:b", "1:2:3:4", "-1:2"})
    expect_error({"render", "scene.json", std::string("--frames=") + wrong, "-o", "f.##.pfm"}, 2,
                 "--frames");
  expect_error({"render", "scene.json", "--frames", "1:2", "-o", "f.pfm"}, 2, "frame.####.exr");
  expect_error({"render", "scene.json", "--frames", "1:2"}, 2, "name the pictures");
  expect_error({"render", "scene.json", "--turntable", "90"}, 2, "--frames");
  expect_error(
      {"render", "scene.json", "--frames", "1:2", "-o", "f.##.pfm", "--detectors", "d.json"}, 2,
      "d.json: has no ##");
  expect_error(
      {"render", "scene.json", "--frames", "1:2", "-o", "f.##.pfm", "--checkpoint", "c.tyn"}, 2,
      "not together");
}

TEST_F(CliTest, FramesHaveReportsAndDetectors) {
  const Outcome outcome =
      run({"render", "scene.json", "--frames", "1:2", "-o", "f.##.pfm", "--report", "r.##.json",
           "--detectors", "d.##.json", "-D", "detectors.flux=[2,2]"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* name : {"f.02.pfm", "r.02.json", "d.01.json", "d.02.json"})
    EXPECT_TRUE(names().contains(name)) << name;
}

// ---- Bakes, the manual

TEST_F(CliTest, BakesLight) {
  const Outcome baked = run({"bake", "scene.json", "-o", "light.json"});
  ASSERT_EQ(baked.code, 0) << baked.err;
  EXPECT_GT(fs::file_size(folder_ / "light.raw"), 1000u);
  EXPECT_NE(contents(folder_ / "light.glsl").find("scattered_light"), std::string::npos);
  expect_error({"bake", "scene.json"}, 2, "--output");
  expect_error({"bake", "scene.json", "-o", "light.exr"}, 2, "only ");
  expect_error({"bake", "scene.json", "-o", "scene.json"}, 2, "the scene itself");
  expect_error({"bake", "scene.json", "-o", "no/light.json"}, 5, "no");
  expect_error({"bake", "none.json", "-o", "light.json"}, 4, "none.json");
  // The files beside the output are outputs, too.
  std::ofstream(folder_ / "grid.raw", std::ios::binary) << std::string(4 * 8, '\0');
  expect_error({"bake", "scene.json", "-D",
                R"(medium.components[0].field={"type":"grid","size":[2,2,2],"file":"grid.raw"})",
                "-o", "grid.json"},
               2, "grid.raw: is read by the scene");
}

TEST_F(CliTest, BakesThatCannotBeAreRefusedBeforeThePhotons) {
  expect_error({"bake", "scene.json", "-o", "a.json", "-o", "a.json"}, 2, "is asked for twice");
  std::string lights = "lights=[";
  for (int i = 0; i < 6; ++i)  // the medium's emission, too
    lights +=
        R"({"type":"point","position":[1.5,2,0.5],"power":1})" + std::string(i < 5 ? "," : "]");
  const Outcome outcome =
      run({"bake", "scene.json", "-o", "a.html", "--per-light", "-D", lights, "-D",
           R"(medium.components[0].emission={"type":"color","radiance":1})"});
  if (outcome.err.find("this build bakes no") == std::string::npos) {
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("room for 6 lights, this scene has 7"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(outcome.err.find("hash  "), std::string::npos) << "photons were shot";
    expect_error({"bake", "scene.json", "--multiple-only", "-o", "a.html"}, 2,
                 "would lack single scattering");
  }
  EXPECT_EQ(run({"bake", "scene.json", "--multiple-only", "-o", "once.json"}).code, 0);
  EXPECT_NE(contents(folder_ / "once.json").find("left out"), std::string::npos);
}

TEST_F(CliTest, StoppedBakesHaveThePhotonsSoFar) {
  const pid_t child = start({"bake", "scene.json", "-o", "light.json", "--photons", "100000000000",
                             "--progress", "plain"});
  for (int i = 0; i < 5000 && contents(scratch_ / "err").find("photons  ") == std::string::npos;
       ++i)
    std::this_thread::sleep_for(2ms);
  ::kill(child, SIGINT);
  const Outcome outcome = wait(child);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_NE(outcome.err.find("the output has"), std::string::npos) << outcome.err;
  EXPECT_TRUE(names().contains("light.raw"));
}

TEST_F(CliTest, TheManualHasEveryOption) {
  std::set<std::string> options;
  for (const char* command : {"render", "merge", "bake", "convert", "info"}) {
    std::istringstream help(run({"help", command}).out);
    for (std::string word; help >> word;)  // "--photons", "-o,--output"
      if (const std::size_t at = word.find("--"); at == 0 || at == 3)
        options.insert(word.substr(at));
  }
  ASSERT_GT(options.size(), 25u);
  for (const char* format : {"man", "bash", "zsh"}) {
    const Outcome outcome = run({"help", "--as", format});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    for (const std::string& option : options) {
      std::string name;
      for (const char c : option)
        name += c == '-' && std::string(format) == "man" ? "\\-" : std::string(1, c);
      EXPECT_NE(outcome.out.find(name), std::string::npos) << format << " " << option;
    }
  }
}

}  // namespace
