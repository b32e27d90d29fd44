"""The benchmark of CUDA devices: `python -m treelet.bench.gpu` measures, `.report` makes tables of it."""
