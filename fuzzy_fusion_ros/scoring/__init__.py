"""How good an estimate is: metrics, reports, and the paper's claims over the benchmark."""
