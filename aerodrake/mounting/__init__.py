"""Vehicles for arms: conversion of an arm's own URDF, sizing of the multirotor, scenario."""
