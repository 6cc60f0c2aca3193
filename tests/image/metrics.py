"""Image metrics by numpy and scikit-image, to compare ours with.

metrics.py IMAGE REFERENCE WIDTH EXPOSURE: two files of raw float32 RGB, row by row. Prints one
figure per line; SSIM over valid windows only.
"""
import sys

import numpy as np
from skimage.metrics import mean_squared_error, peak_signal_noise_ratio, structural_similarity

width, exposure = int(sys.argv[3]), float(sys.argv[4])
a, r = (np.fromfile(path, np.float32).astype(np.float64).reshape(-1, width, 3) / exposure
        for path in sys.argv[1:3])
print(f"rmse {np.sqrt(mean_squared_error(r, a)):.17g}")
print(f"psnr {peak_signal_noise_ratio(r, a, data_range=1):.17g}")
print(f"rel_mse {np.mean((a - r) ** 2 / (r ** 2 + 0.01 * np.mean(r) ** 2)):.17g}")
la, lr = (np.clip(image @ [0.2126, 0.7152, 0.0722], 0, 1) for image in (a, r))
full = structural_similarity(la, lr, gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
                             data_range=1, full=True)[1]
print(f"ssim {full[5:-5, 5:-5].mean():.17g}")
