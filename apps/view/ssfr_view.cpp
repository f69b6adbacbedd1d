// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/common/program_main.h>
#include <apps/io/io_error.h>
#include <apps/view/view_model.h>
#include <apps/view/view_options.h>
#include <apps/view/view_pictures.h>
#include <apps/view/view_text.h>
#include <apps/view/view_window.h>

#include <pcl/console/print.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace {

using namespace pcl_ssfr;

/// Exit codes that scripts rely on.
enum ExitCode { kDone = 0 };

/// Find out before any work whether what is asked for can be shown.
void
checkDisplay(const apps::ViewArguments& arguments)
{
  const std::filesystem::path folder = std::filesystem::path(arguments.screenshot).parent_path();
  std::error_code error;
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    throw io::IoError(arguments.screenshot + ": cannot be written: " + folder.string() + " is no folder");
  if (!arguments.window)
    return;
  if (!apps::hasWindow())
    throw apps::UsageError("built without PCL's visualization, so there is no window; --png DIR draws pictures");
  const char* display = std::getenv("DISPLAY");
  if (!display || !*display)
    throw apps::UsageError("there is no display (DISPLAY is not set); --png DIR draws pictures without one");
  if (!apps::canOpenDisplay())
    throw apps::UsageError(std::string("the display ") + display +
                           " cannot be opened; --png DIR draws pictures without one");
}

int
run(const std::vector<std::string>& tokens)
{
  const apps::ViewArguments arguments = apps::parseViewArguments(tokens);
  if (arguments.help || arguments.version) {
    std::cout << (arguments.help ? apps::viewHelp() : std::string("ssfr_view " PCL_SSFR_VERSION "\n"));
    return kDone;
  }
  checkDisplay(arguments);
  apps::warnOfUnread(arguments.method, "ssfr_view", std::cerr);
  const apps::ViewModel model(apps::loadRun(arguments), arguments.candidate);
  std::cout << apps::describeRun(model) << std::flush;
  if (!arguments.pictures.empty()) {
    apps::writeViewPage(arguments.pictures, model, apps::drawViewPictures(arguments.pictures, model));
    std::cout << "Pictures: " << arguments.pictures << "/index.html\n" << std::flush;
  }
  if (!std::cout)
    throw io::IoError("standard output: cannot be written");
  if (arguments.window)
    apps::showWindow(model, arguments.layer, arguments.screenshot);
  return kDone;
}

} // namespace

int
main(int argc, char** argv)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); // this program reports errors itself
  return apps::runProgram("ssfr_view", argc, argv, run);
}
