#include "app/manual.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace tyndall::app {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->nonpositional(); });
}

std::vector<const CLI::Option*> positionals_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

/// "-o", "--output"
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(between)) + word;
  return text;
}

/// \return `text` with each `from` replaced by `to`.
std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

// ---- man

std::string roff(const std::string& text) {
  std::string out = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
  if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out = "\\&" + out;
  return replaced(std::move(out), "\n", "\n.br\n");
}

std::string roff_of(const CLI::Option& option, const std::string& name) {
  const std::string value =
      takes_value(option) ? fmt::format(" \\fI{}\\fR", roff(option.get_type_name())) : "";
  return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), value, roff(option.get_description()));
}

std::string man_page(const CLI::App& app, const std::string& examples) {
  std::string page = fmt::format(
      ".TH TYNDALL 1 \"\" \"tyndall {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
      TYNDALL_VERSION, app.get_name(), roff(app.get_description()));
  for (const CLI::App* command : commands_of(app)) {
    page += fmt::format(".B {} {}\n[\\fIOPTIONS\\fR]", app.get_name(), command->get_name());
    for (const CLI::Option* option : positionals_of(*command))
      page += fmt::format(" \\fI{}\\fR", roff(option->get_name(true)));
    page += "\n.br\n";
  }
  page += ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) {
    page += fmt::format(".SS {}\n{}.\n", command->get_name(), roff(command->get_description()));
    for (const CLI::Option* option : positionals_of(*command))
      page += roff_of(*option, option->get_name(true));
    for (const CLI::Option* option : options_of(*command))
      page += roff_of(*option, joined(names_of(*option), ", "));
  }
  page += ".SH EXAMPLES\n.nf\n" + replaced(roff(examples), "\n.br\n", "\n") + "\n.fi\n";
  page +=
      ".SH EXIT STATUS\n0 done, 1 an internal error, 2 a wrong command line, 3 a wrong scene, 4 an "
      "input that is missing or damaged, 5 an output that cannot be written, 6 too little memory, "
      "7 "
      "no usable GPU, 8 a time limit too short for a picture, 128 + N ended by signal "
      "N.\n";
  return page;
}

// ---- Completions

std::string pattern_of(const std::string& command) {
  if (command == "merge") return "*.tyn";
  return command == "info" ? "*.*" : "*.json";
}

/// \return the values of an option, separated by spaces; empty if any value is possible.
std::string words_of(const std::string& option) {
  if (option == "--device") return "auto cpu cuda cuda:0";
  return option == "--progress" ? "auto bar plain none" : "";
}

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> names;
  std::string cases;
  for (const CLI::App* command : commands_of(app)) {
    names.push_back(command->get_name());
    std::vector<std::string> options;
    for (const CLI::Option* option : options_of(*command))
      for (const std::string& name : names_of(*option)) options.push_back(name);
    cases += fmt::format("    {}) options=\"{}\" pattern='{}' ;;\n", command->get_name(),
                         joined(options, " "), pattern_of(command->get_name()));
  }
  return fmt::format(R"(# bash completion for tyndall
_tyndall() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} options="" pattern=""
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "{} --help --version" -- "$current")
    return
  fi
  case ${{COMP_WORDS[1]}} in
{}  esac
  case $previous in
    --device) mapfile -t COMPREPLY < <(compgen -W "{}" -- "$current"); return ;;
    --progress) mapfile -t COMPREPLY < <(compgen -W "{}" -- "$current"); return ;;
    -o | --output | --report | --detectors | --checkpoint | --illumination | --preview)
      mapfile -t COMPREPLY < <(compgen -f -- "$current"); return ;;
  esac
  if [[ ${{COMP_WORDS[1]}} == help ]]; then
    mapfile -t COMPREPLY < <(compgen -W "{}" -- "$current")
  elif [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  else
    mapfile -t COMPREPLY < <(compgen -f -X "!$pattern" -- "$current"; compgen -d -S / -- "$current")
  fi
}}
complete -o filenames -o bashdefault -F _tyndall tyndall
)",
                     joined(names, " "), cases, words_of("--device"), words_of("--progress"),
                     joined(names, " "));
}

std::string zsh_text(const std::string& text) {
  std::string out = replaced(replaced(text, "'", "'\\''"), "[", "\\[");
  return replaced(replaced(std::move(out), "]", "\\]"), ":", "\\:");
}

std::string zsh_completion(const CLI::App& app) {
  std::string names, every, cases;
  for (const CLI::App* command : commands_of(app)) every += " " + command->get_name();
  for (const CLI::App* command : commands_of(app)) {
    names +=
        fmt::format("    '{}:{}'\n", command->get_name(), zsh_text(command->get_description()));
    cases += fmt::format("      {})\n        _arguments \\\n", command->get_name());
    for (const CLI::Option* option : options_of(*command)) {
      const std::vector<std::string> all = names_of(*option);
      const std::string name = all.back(), words = words_of(name);
      const std::string value = !takes_value(*option) ? ""
                                : words.empty()
                                    ? fmt::format(":{}:_files", option->get_type_name())
                                    : fmt::format(":{}:({})", option->get_type_name(), words);
      for (const std::string& each : all)
        cases += fmt::format("          '*{}[{}]{}' \\\n", each,
                             zsh_text(option->get_description()), replaced(value, "A:B", "range"));
    }
    cases += command->get_name() == "help"
                 ? fmt::format("          '*:command:({})' ;;\n", every.substr(1))
                 : fmt::format("          '*:file:_files -g \"{}\"' ;;\n",
                               pattern_of(command->get_name()));
  }
  return fmt::format(R"(#compdef tyndall
_tyndall() {{
  local -a commands
  commands=(
{}  )
  if ((CURRENT == 2)); then
    _describe command commands
  else
    local command=$words[2]
    shift words
    ((CURRENT--))
    case $command in
{}    esac
  fi
}}
_tyndall "$@"
)",
                     names, cases);
}

}  // namespace

std::string manual(const CLI::App& app, const std::string& format, const std::string& examples) {
  if (format == "man") return man_page(app, examples);
  return format == "bash" ? bash_completion(app) : zsh_completion(app);
}

}  // namespace tyndall::app
