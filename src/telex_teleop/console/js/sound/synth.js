// @ts-check
/** Makes sounds out of oscillators and noise. What is no number makes none. */

/** @typedef {import("./motors.js").Group} Group */
/** @typedef {import("./motors.js").MotorSound} MotorSound */
/** @typedef {import("./motors.js").GroundSound} GroundSound */
/** @typedef {import("./microphone.js").MicrophoneSound} MicrophoneSound */
/** @typedef {import("./patterns.js").Tone} Tone */

const SMOOTH = 0.06; // s in which a sound follows what it tells of
const EDGE = 0.008; // s in which a tone begins and ends: without it clicks

const CURVE = 257; // points of a microphone's clipping
const NOISE_LENGTH = 2; // s, after which the noise begins anew
const RUNNING = 0.3, ALARM = 0.4; // how loud motors and alarms are of what the loudspeaker gives

/** Slip of the fingers: where its noise lies, and how broad it is (Hz). */
const SCRAPE = { pitch: 3200, width: 2400 };

export class Synth {
  /** @param {BaseAudioContext} context */
  constructor(context) {
    this._context = context;
    this._out = context.createGain();
    this._out.connect(context.destination);
    this._clip = context.createWaveShaper();
    /** What the microphone clips at. */
    this._limit = 1;
    this._clip.connect(this._gain(RUNNING, this._out));
    this._running = this._gain(1, this._clip);
    this._alarms = this._gain(ALARM, this._out);
    this._motors = {
      tracks: this._makeMotor("sawtooth"), flippers: this._makeMotor("square"), arm: this._makeMotor("triangle"),
    };
    const noise = this._makeNoise();
    this._hiss = this._gain(0, this._running);
    noise.connect(this._hiss);
    this._ground = this._makeBand(noise);
    this._scrape = this._makeBand(noise);
    this._scrape.filter.frequency.value = SCRAPE.pitch;
    this._scrape.filter.Q.value = SCRAPE.pitch / SCRAPE.width;
    // Treads: between nothing and twice its mean.
    this._beat = context.createOscillator();
    this._stroke = this._gain(0, this._ground.gain.gain);
    this._beat.connect(this._stroke);
    this._beat.start();
    noise.start();
    /** Oscillators of the alarm that sounds. @type {OscillatorNode[]} */
    this._tones = [];
    /** Where parameters go. @type {Map<AudioParam, number>} */
    this._goals = new Map();
  }

  /** @param {number} volume  0 to 1 */
  setVolume(volume) {
    this._follow(this._out.gain, volume ** 2); // ears count by ratios
  }

  /** @param {MicrophoneSound} sound */
  setMicrophone({ hiss, limit }) {
    this._follow(this._hiss.gain, hiss);
    // Browsers may refuse a second curve; of another robot the page is loaded anew.
    if (limit === this._limit) return;
    this._limit = limit;
    // It maps -1 to 1; without a curve everything passes.
    const clipped = (/** @type {number} */ value) => Math.max(-limit, Math.min(limit, value));
    this._clip.curve = limit < 1 ? Float32Array.from({ length: CURVE }, (_, index) => clipped((2 * index) / (CURVE - 1) - 1)) : null;
  }

  /**
   * @param {Group} group
   * @param {MotorSound} sound
   */
  setMotor(group, { pitch, tone, gain }) {
    const motor = this._motors[group];
    if (![pitch, tone, gain].every(Number.isFinite)) return this._follow(motor.gain.gain, 0);
    this._follow(motor.oscillator.frequency, pitch);
    this._follow(motor.filter.frequency, tone);
    this._follow(motor.gain.gain, gain);
  }

  /** @param {GroundSound} sound */
  setGround({ pitch, width, gain, beat, stroke }) {
    const isSound = [pitch, width, gain, beat, stroke].every(Number.isFinite);
    const { filter, gain: loudness } = this._ground, loud = isSound ? gain : 0;
    this._follow(loudness.gain, loud);
    this._follow(this._stroke.gain, isSound ? loud * stroke : 0);
    if (!isSound) return;
    this._follow(filter.frequency, pitch);
    this._follow(filter.Q, pitch / width);
    this._follow(this._beat.frequency, beat);
  }

  /** @param {number} strength  Of something that slips, 0 to 1. */
  setScrape(strength) {
    this._follow(this._scrape.gain.gain, strength);
  }

  /** Something is touched. @param {number} strength  0 to 1 */
  knock(strength) {
    if (!(strength > 0)) return;
    const { currentTime: now } = this._context;
    const { oscillator, gain } = this._makeTone("triangle", this._running);
    oscillator.frequency.setValueAtTime(190, now);
    oscillator.frequency.exponentialRampToValueAtTime(65, now + 0.12);
    gain.gain.setValueAtTime(Math.min(1, 0.3 + 0.7 * strength), now);
    gain.gain.exponentialRampToValueAtTime(0.001, now + 0.16);
    oscillator.start(now);
    oscillator.stop(now + 0.17);
  }

  /** Sound an alarm, in place of what sounds. @param {Tone[]} tones */
  sound(tones) {
    this.quiet();
    const { currentTime: begin } = this._context;
    this._tones = tones.map(({ at, pitch, to = pitch, length }) => {
      const { oscillator, gain } = this._makeTone("square", this._alarms), from = begin + at, end = from + length;
      oscillator.frequency.setValueAtTime(pitch, from);
      oscillator.frequency.linearRampToValueAtTime(to, end);
      gain.gain.setValueAtTime(0, from);
      gain.gain.linearRampToValueAtTime(1, from + EDGE);
      gain.gain.setValueAtTime(1, end - EDGE);
      gain.gain.linearRampToValueAtTime(0, end);
      oscillator.start(from);
      oscillator.stop(end);
      return oscillator;
    });
  }

  /** End the alarm that sounds. */
  quiet() {
    for (const tone of this._tones.splice(0)) tone.stop();
  }

  /**
   * @param {AudioParam} parameter
   * @param {number} value
   */
  _follow(parameter, value) {
    const goal = Number.isFinite(value) ? value : 0;
    if (this._goals.get(parameter) === goal) return;
    this._goals.set(parameter, goal);
    parameter.setTargetAtTime(goal, this._context.currentTime, SMOOTH);
  }

  /**
   * @param {number} value
   * @param {AudioNode | AudioParam} into
   */
  _gain(value, into) {
    const gain = this._context.createGain();
    gain.gain.value = value;
    gain.connect(/** @type {any} */ (into));
    return gain;
  }

  /** @param {OscillatorType} type @param {AudioNode} into */
  _makeTone(type, into) {
    const oscillator = this._context.createOscillator(), gain = this._gain(0, into);
    oscillator.type = type;
    oscillator.connect(gain);
    return { oscillator, gain };
  }

  /** @param {OscillatorType} type */
  _makeMotor(type) {
    const { oscillator, gain } = this._makeTone(type, this._running), filter = this._context.createBiquadFilter();
    filter.type = "lowpass";
    oscillator.disconnect();
    oscillator.connect(filter);
    filter.connect(gain);
    oscillator.start();
    return { oscillator, filter, gain };
  }

  _makeNoise() {
    const { sampleRate } = this._context;
    const buffer = this._context.createBuffer(1, NOISE_LENGTH * sampleRate, sampleRate);
    const samples = buffer.getChannelData(0);
    for (let index = 0; index < samples.length; index += 1) samples[index] = 2 * Math.random() - 1;
    const noise = this._context.createBufferSource();
    noise.buffer = buffer;
    noise.loop = true;
    return noise;
  }

  /** @param {AudioNode} noise */
  _makeBand(noise) {
    const filter = this._context.createBiquadFilter(), gain = this._gain(0, this._running);
    filter.type = "bandpass";
    noise.connect(filter);
    filter.connect(gain);
    return { filter, gain };
  }
}
