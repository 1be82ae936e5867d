% A pneumatic muscle as a plant for mgpi: plays for the hysteresis, an S-shaped curve, a valve with a lag of 50 ms.
%
%   mgpi pil --model model.toml --reference reference.csv --plant-command 'octave -qf examples/plant.m'
%   mgpi pil --model model.toml --reference reference.csv --plant-command 'matlab -batch "run(''examples/plant.m'')"'
%
% Each line in is `time_s command_bar`, each line out `pressure_bar contraction_mm` at that time. Run with GNU Octave 7.3;
% it uses nothing that MATLAB lacks, but has not been run there: MATLAB takes long to start (--plant-timeout-s 60), and must
% print nothing else.
if exist('OCTAVE_VERSION', 'builtin')
  in = stdin; out = stdout;
else
  in = fopen('/dev/stdin', 'r'); out = fopen('/dev/stdout', 'w');
end
pressure_bar = 0; last_s = NaN;
widths_bar = [0.05, 0.1, 0.2, 0.4]; states_bar = zeros(1, 4);
while true
  % Byte by byte: fgetl waits for the byte behind the line.
  line = ''; byte = fread(in, 1);
  while ~isempty(byte) && byte ~= 10
    line(end + 1) = char(byte); byte = fread(in, 1);
  end
  if isempty(byte), break, end
  numbers = sscanf(line, '%f');
  time_s = numbers(1); command_bar = min(max(numbers(2), 0), 6);
  if ~isnan(last_s)
    pressure_bar = pressure_bar + (command_bar - pressure_bar) * (1 - exp((last_s - time_s) / 0.05));
  end
  last_s = time_s;
  states_bar = max(pressure_bar - widths_bar, min(pressure_bar + widths_bar, states_bar));
  felt_bar = mean(states_bar);
  fprintf(out, '%.9g %.9g\n', pressure_bar, 130 * felt_bar^2 / (felt_bar^2 + 4));
  if exist('OCTAVE_VERSION', 'builtin'), fflush(out); end
end
