#include "volume_study/line_plot.h"

#include <sstream>

#include "io/file.h"
#include "study/plots.h"

namespace probebake::volume_study {

bool write_plot(const std::filesystem::path& folder, const LinePlot& plot) {
    // One block of points per line, as gnuplot's `index` reads them.
    std::ostringstream data;
    std::string lines;
    for (size_t i = 0; i < plot.lines.size(); ++i) {
        data << "# " << plot.lines[i].name << '\n';
        for (const PlotPoint& p : plot.lines[i].points) data << p.x << ' ' << p.y << '\n';
        data << "\n\n";
        lines += (i > 0 ? ", \\\n     '" : "plot '") + plot.name + ".dat' index " +
                 std::to_string(i) + " with linespoints title '" + plot.lines[i].name + "'";
    }
    write_file_atomically(folder / (plot.name + ".dat"), data.str());
    const std::string logs = plot.log_axes.empty() ? "" : "set logscale " + plot.log_axes + "\n";
    write_file_atomically(folder / (plot.name + ".gp"),
                          "set terminal svg size 720,480 dynamic background rgb 'white'\n"
                          "set output '" +
                              plot.name + ".svg'\nset title \"" + plot.title +
                              "\" noenhanced\nset xlabel '" + plot.x_label + "'\nset ylabel '" +
                              plot.y_label + "'\nset key outside right noenhanced\nset grid\n" +
                              logs + lines + "\n");
    return study::run_gnuplot(folder, plot.name + ".gp");
}

}  // namespace probebake::volume_study
