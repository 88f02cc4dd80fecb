# Which scheme takes which steps, from what taut_promise --schemes writes.
set terminal pngcairo size 1000,640 font "DejaVu Sans,13"
set output "out/results/schemes.png"
set datafile separator ","
set logscale xy
set format xy "10^{%T}"
set xlabel "highest frequency of waves under the tensions (rad/s)"
set ylabel "step (s)"
set xrange [1:1e6]
set yrange [1e-7:1]
set key bottom left box opaque samplen 2
set grid
file = "out/results/schemes.csv"
of(name) = "< grep ',".name."$' ".file
plot of("dop853") using 4:5 with points pt 7 ps 0.35 lc rgb "#4477aa" title "DOP853", \
     of("adams") using 4:5 with points pt 7 ps 0.35 lc rgb "#ee9922" title "Adams", \
     of("rosenbrock") using 4:5 with points pt 7 ps 0.35 lc rgb "#228833" title "ROS34PW2", \
     5.2 / x with lines lw 2 dt 1 lc rgb "#223355" title "DOP853's limit, 5.2 over the frequency", \
     1.4 / x with lines lw 2 dt 2 lc rgb "#884400" title "Adams's limit, 1.4 over the frequency"
