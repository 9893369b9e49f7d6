#include "core/laboratory/chart/plot_script.h"

namespace qray {

const char* const kPlotScript = R"gp(
scenes = |title|
series = |colour|
legend_dash(text) = strstrt(text, ', biased') ? 2 : 1
set encoding utf8
set logscale xy
set format '%g'
set grid xtics ytics lc rgb 0xdddddd lt 1 lw 0.5
set border 3 lc rgb 0x555555
set tics nomirror scale 0.7 textcolor rgb 0x222222
set style fill transparent solid 0.15 noborder

# Every scene as a chart of its own, then all of them as SVG and as PNG.
do for [picture = 1:scenes + 2] {
  one = picture <= scenes
  columns = one ? 1 : all_columns
  rows = one ? 1 : (scenes + columns - 1) / columns
  panel_px = columns == 1 ? 640 : 480
  panel_high_px = columns == 1 ? 430 : 340
  legend_columns = one ? legend_columns_one : legend_columns_all
  first = one ? picture : 1
  last = one ? picture : scenes
  names = one ? picture * series : 0
  used = 0
  do for [i = 1:series] { used = used + (label[names + i] ne '') }
  legend_px = 48 + 20 * ((used + legend_columns - 1) / legend_columns)
  wide = columns * panel_px
  high_px = rows * panel_high_px + legend_px
  if (picture == scenes + 2) {
    set terminal pngcairo noenhanced size 2 * wide, 2 * high_px font 'sans-serif,11' \
      fontscale 2 linewidth 2 pointscale 2 background '#ffffff'
    set output 'chart.png'
  } else {
    set terminal svg noenhanced size wide, high_px font 'sans-serif,13' background '#ffffff'
    set output one ? folder[picture] . '/chart.svg' : 'chart.svg'
  }
  set multiplot
  set size 1.0 / columns, real(panel_high_px) / high_px
  set lmargin 10; set rmargin 2; set tmargin 2.6; set bmargin 3.4
  set border 3; set xtics nomirror 10; set ytics nomirror 10; set mxtics 10; set mytics 10
  set xlabel 'seconds' offset 0, 0.3
  set ylabel 'error (relMSE)' offset 0.5, 0
  set xrange [x_low:x_high]
  unset key
  if (x_high / x_low < 200) {
    do for [k = -6:6] {
      set xtics add (sprintf('%g', 2 * 10.0**k) 2 * 10.0**k, sprintf('%g', 5 * 10.0**k) 5 * 10.0**k)
    }
  }
  do for [s = first:last] {
    column_of = (s - first) % columns
    row_of = (s - first) / columns
    set origin real(column_of) / columns, 1 - real((row_of + 1) * panel_high_px) / high_px
    set title title[s] font ',15'
    set yrange [low[s]:high[s]]
    if (high[s] / low[s] < 200) {
      do for [k = -12:6] {
        set ytics add (sprintf('%g', 2 * 10.0**k) 2 * 10.0**k, \
          sprintf('%g', 5 * 10.0**k) 5 * 10.0**k)
      }
    } else { set ytics nomirror 10 }
    unset object
    unset label
    if (floor[s] > low[s]) {
      set object 1 rect from graph 0, graph 0 to graph 1, first floor[s] behind \
        fc rgb 0xd9d9d9 fs solid noborder
      set label 1 sprintf("the reference's own error, %.2g", floor[s]) \
        at graph 0.02, first floor[s] offset 0, -0.6 textcolor rgb 0x444444
    } else {
      set label 1 floor[s] < 0 ? "the reference's own error is not known" : \
        sprintf("the reference's own error, %.2g, is below this", floor[s]) \
        at graph 0.02, graph 0.06 textcolor rgb 0x444444
    }
    plot for [i = 1:series] 'chart.dat' \
        using ($1 == s && $2 == i ? $3 : NaN):5:6 with filledcurves lc rgb colour[i] notitle, \
      for [i = 1:series] 'chart.dat' using ($1 == s && $2 == i ? $3 : NaN):4 \
        with linespoints lc rgb colour[i] pt point[i] ps 0.9 lw 1.6 \
        dt dash[(s - 1) * series + i] notitle
  }
  set origin 0, 0
  set size 1, real(legend_px) / high_px
  set margins 0, 0, 0, 0
  unset title; unset xlabel; unset ylabel; unset tics; unset border; unset object; unset label
  set key center top horizontal Left reverse maxcols legend_columns samplen 3.5
  set label 1 note at graph 0.5, graph 16.0 / legend_px center textcolor rgb 0x444444
  unset logscale
  set xrange [0:1]; set yrange [0:1]
  plot for [i = 1:series] NaN with linespoints lc rgb colour[i] pt point[i] ps 0.9 lw 1.6 \
    dt legend_dash(label[names + i]) title label[names + i]
  set logscale xy
  unset multiplot
}
unset output
)gp";

}  // namespace qray
