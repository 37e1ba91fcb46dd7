// The commands that print a list and take no options: devices, schema, defaults.
#include <string>

#include "app/command.h"
#include "io/scene_json.h"
#include "session/console.h"
#include "session/devices.h"

namespace tyndall::app {
namespace {

template <std::string (*list)()>
Run add(CLI::App&) {
  return [] {
    session::print(list());
    return ExitCode::done;
  };
}

}  // namespace

const Command devices_command{"devices", "Lists the devices", &add<session::list_devices>};
const Command schema_command{"schema", "Prints the JSON Schema of scenes", &add<io::schema>};
const Command defaults_command{"defaults", "Prints every key of a scene with its default",
                               &add<io::defaults>};

}  // namespace tyndall::app
