// uPlot writes numbers by navigator.language, which is no language tag (en-US@posix) in a browser under LANG=C.UTF-8: then in English.
try {
  new Intl.NumberFormat(navigator.language);
} catch {
  Object.defineProperty(navigator, "language", { value: "en-US", configurable: true });
}
